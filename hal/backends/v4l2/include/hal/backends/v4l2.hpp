#pragma once
#include <memory>
#include <vector>

#include "hal/backends.hpp"

namespace onemap::hal {

// UVC depth cameras (RealSense D4xx, Orbbec and their kin) through the kernel's V4L2, without a vendor's library: a
// depth node (Z16 or Y16) and a colour node (YUYV, UYVY, MJPEG or GREY) on one USB device.
//
//   v4l2:                    the first device that has both
//   v4l2:/dev/videoN         this depth node
//
//   option       default             meaning
//   color        on the same device  the colour node, /dev/videoM
//   calibration  the model's         file: hal/imaging/rig_calibration.hpp; without it the nominal one that onemap
//                                    ships for the model and the shape of the sizes, and an error for a model that it
//                                    does not know
//   size         the calibration's   of colour images, WxH
//   depth_size   the calibration's   of depth images, WxH
//   fps          30                  of both
//   registration ours                none: depth as its own lens sees it, for onemapctl calibrate; not of cameras whose
//                                    depth and colour images have different shapes (Femto Mega, Gemini 2)
//
// Depth is moved onto the colour image here when the calibration has a lens of its own for it; if not, the device has
// done it, and depth stays where the driver put it (no copy). Times are the kernel's stamps plus clock_offset. An
// unplugged camera is Grab::gone until it is back at the same port; one that is there and has given nothing for five
// seconds is opened anew. Images without a partner in time are counted, and so are frames that the driver dropped for
// want of a buffer.
Result<std::unique_ptr<DepthCamera>> open_v4l2(const CameraAddress& address);

// Its form and its options, before any device is looked for.
Status check_v4l2(const CameraAddress& address);

// Every device with a depth node, and every node that may be one: what cannot be opened or asked, and what offers Y16
// alone, which is depth or infrared. Those first that can be used, and of them those first that do at their port all
// that they could. The address asks for fewer frames a second where the port has no 30.
std::vector<CameraInfo> list_v4l2();

}  // namespace onemap::hal
