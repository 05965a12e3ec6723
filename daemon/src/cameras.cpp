#include "daemon/cameras.hpp"

#include <array>

#include "hal/backends/replay.hpp"
#include "hal/backends/simulated.hpp"
#include "hal/backends/v4l2.hpp"

namespace onemap::daemon {

namespace {
constexpr std::array kBackends{
    hal::Backend{"replay", "a recorded sequence (TUM RGB-D or 7-Scenes layout): replay:DIR or replay:DIR:FROM:TO",
                 hal::open_replay, hal::check_replay},
    hal::Backend{"simulated", "a room from formulas: simulated:SCENE?robot=N&robots=M&frames=F&seed=S",
                 hal::open_simulated, hal::check_simulated},
    hal::Backend{"v4l2", "a UVC depth camera (RealSense, Orbbec): v4l2: or v4l2:/dev/videoN?calibration=FILE",
                 hal::open_v4l2, nullptr, hal::list_v4l2},
};
}  // namespace

std::span<const hal::Backend> camera_backends() { return kBackends; }

}  // namespace onemap::daemon
