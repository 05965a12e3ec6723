#pragma once
#include <memory>
#include <vector>

#include "hal/backends.hpp"

namespace onemap::hal {

// Kinect v1 (of the Xbox 360, 045e:02ae, and for Windows, 045e:02bf) by libusb and libfreenect, 640x480 at 30 Hz:
// `libusb:` the first, `libusb:SERIAL` this one (as --cameras lists it). Tilt and LED are left alone.
//
//   option        default        meaning
//   registration  device, else   who moves depth into the colour image: device, by what the factory measured and the
//                 ours           device remembers, as libfreenect does it; ours, from nominal lenses and the baseline;
//                 none: it is there
//   baseline      0.025          metres from the depth camera to the colour camera on its right, for ours
//   calibration   -              a file of `key value` lines for the colour image; without it 525 pixels, the middle
//   fx fy cx cy k1 k2 p1 p2 k3 depth_scale noise_least_m noise_growth_per_m noise_best_m   over the calibration
//
// The device's stamps count from its own start: times are its stamps plus the address's clock_offset. When it comes
// back time goes on after what was waited for it. A Kinect that was pulled out is gone until the same, by its serial
// number where it has one, is plugged in; one that was there beside it is another, whatever its number. One that is
// there and has given nothing for five seconds is opened anew.
Result<std::unique_ptr<DepthCamera>> open_libusb(const CameraAddress& address);

// Its form and its options, before any device is looked for. The calibration file that it names is read.
Status check_libusb(const CameraAddress& address);

// The Kinects on this machine's USB; the problem says when one cannot be opened or has no high-speed port.
std::vector<CameraInfo> list_libusb();

}  // namespace onemap::hal
