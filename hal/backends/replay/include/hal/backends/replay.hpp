#pragma once
#include <memory>
#include <string_view>

#include "hal/backends.hpp"

namespace onemap::hal {

// `replay:DIR` or `replay:DIR:FROM:TO` (frames FROM up to, not including, TO, counted after association).
// Plays a recorded sequence, every frame, as fast as it is asked:
// * TUM RGB-D layout: rgb.txt + depth.txt, paired by time, else associations.txt as it stands. PNG or JPEG colour,
//   16-bit PNG depth, depth_scale 5000 unless given.
// * 7-Scenes layout: frame-NNNNNN.color.png + frame-NNNNNN.depth.png at 30 Hz; depth 65535 is no reading; without a
//   calibration the data set's own (fx fy 585, cx 320, cy 240, depth_scale 1000).
// Calibration: DIR/calibration.txt, one `key value` a line, and options over it: fx fy cx cy k1 k2 p1 p2 k3
// depth_scale noise_least_m noise_growth_per_m noise_best_m. Further options: max_dt (seconds between colour and depth,
// 0.02), layout (tum or 7scenes; found out by itself), depth_time (own: as the depth list says; colour, else: the
// stamps of most recordings are of when an image came). Unusable lines of the lists are delivered first, each as one
// Grab::bad with file:line; then the frames, with Grab::bad for each that cannot be read. All images have the size of
// the first good frame. A depth list that begins with this line has depth's own time by itself.
inline constexpr std::string_view kOwnDepthTime = "# depth images, each at the time of its measurement";

Result<std::unique_ptr<DepthCamera>> open_replay(const CameraAddress& address);
Status check_replay(const CameraAddress& address);  // its form and its options

}  // namespace onemap::hal
