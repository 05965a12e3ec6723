#pragma once
#include <memory>
#include <vector>

#include "hal/backends.hpp"

namespace onemap::hal {

// PrimeSense's sensors, Asus Xtion, Kinect-class devices and recordings through the OpenNI2 library and its drivers:
// `openni2:` the first device, `openni2:URI` this one (as --cameras lists them), `openni2:FILE.oni` a recording.
//
//   option        default             meaning
//   mode          640x480@30          size and rate of both streams; without the option, when there is no such mode,
//                                     the first that depth and colour have in common
//   registration  device, else ours;  who moves depth into the colour image: the device; ours, from the two fields of
//                 a recording: none   view and the baseline; or none, because it is there (a recording does not tell)
//   baseline      0.025               metres from the depth camera to the colour camera on its right, for ours
//   calibration   -                   a file of `key value` lines for the colour image; without it the field of view
//                                     that the device gives, else 525 pixels at a width of 640
//   fx fy cx cy k1 k2 p1 p2 k3 depth_scale noise_least_m noise_growth_per_m noise_best_m   over the calibration
//
// A device's stamps count from its own start: times are its stamps plus the address's clock_offset. When it comes back
// with a new clock, time goes on after what was waited for it. A recording's times are its stamps. A device that was
// pulled out is gone until the same (by its USB ids and its serial number, and none that was there beside it) is
// plugged in; one that is there and has given nothing for five seconds is opened anew. Where the drivers hear of
// nothing (no udev in a container), they are begun anew every three seconds while it is away. A recording plays every
// frame as fast as it is asked.
Result<std::unique_ptr<DepthCamera>> open_openni2(const CameraAddress& address);

// Its form and its options, before any device is looked for. The calibration file that it names is read.
Status check_openni2(const CameraAddress& address);

// The devices that OpenNI2's drivers see when they begin, which needs no udev, with what the kernel has against one
// (usb_place.hpp). None is opened.
std::vector<CameraInfo> list_openni2();

}  // namespace onemap::hal
