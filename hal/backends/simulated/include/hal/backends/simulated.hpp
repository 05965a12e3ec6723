#pragma once
#include <memory>

#include "hal/backends.hpp"

namespace onemap::hal {

// `simulated:SCENE?robot=N&robots=M&frames=F&seed=S&noise=kinect|none&width=W&height=H`: a room from formulas.
Result<std::unique_ptr<DepthCamera>> open_simulated(const CameraAddress& address);

}  // namespace onemap::hal
