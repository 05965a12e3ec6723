#pragma once
#include <memory>

#include "hal/backends.hpp"

namespace onemap::hal {

// `replay:DIR` or `replay:DIR:FROM:TO` (frames FROM up to, not including, TO, counted after association).
// Plays a recorded sequence: the TUM RGB-D layout or the 7-Scenes layout, every frame, as fast as it is asked.
// Options: fx fy cx cy k1 k2 p1 p2 k3 depth_scale (over calibration.txt), max_dt (seconds between colour and depth).
Result<std::unique_ptr<DepthCamera>> open_replay(const CameraAddress& address);

}  // namespace onemap::hal
