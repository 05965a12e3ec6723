#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "hal/base/result.hpp"
#include "hal/depth_noise.hpp"
#include "hal/frame.hpp"
#include "hal/imaging/image_size.hpp"
#include "hal/imaging/register_depth.hpp"

namespace onemap::hal::imaging {

// What is known of a camera with a colour and a depth lens on one body. As text, one `key value` a line, '#' starts a
// comment:
//
//   width height fx fy cx cy          the colour lens, in pixels of images of this size; needed
//   k1 k2 p1 p2 k3                    its distortion (OpenCV's)
//   depth_scale                       depth values a metre: 1000 when the device counts millimetres; needed
//   depth_offset_m                    metres that are added to each depth, when depth has a lens of its own
//   depth_none                        the device's value for no reading beside 0
//   depth_width depth_height depth_fx depth_fy depth_cx depth_cy
//   depth_k1 depth_k2 depth_p1 depth_p2 depth_k3
//                                     the depth lens; without it, depth is registered to colour by the device
//   colour_from_depth_x _y _z         metres: the depth lens's place in the colour camera's frame (x right, y down,
//                                     z forward)
//   colour_from_depth_qx _qy _qz _qw  its turn, a unit quaternion of at most 30 degrees
//   noise_least_m noise_growth_per_m noise_best_m
//                                     the deviation of depth: see hal/depth_noise.hpp
struct RigCalibration {
  Intrinsics colour;
  std::optional<Intrinsics> depth;
  ColourFromDepth pose;
  std::uint16_t depth_none = 0;
  double depth_offset_m = 0;
  DepthNoise noise;
};

// The error names NAME:LINE, or NAME and what is missing.
Result<RigCalibration> parse_rig_calibration(std::string_view text, const std::string& name);

// The text that gives it again.
std::string text_of(const RigCalibration& rig);

// The same lens on images of another size: all of the sensor's picture, scaled. A size of another shape is a cut that
// the calibration knows nothing of, and an error (a reason only).
Result<Intrinsics> scaled_to(const Intrinsics& k, ImageSize size);

}  // namespace onemap::hal::imaging
