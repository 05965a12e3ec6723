#include "daemon/cameras.hpp"

#include <fmt/format.h>

#include <array>

#include "hal/backends/libusb.hpp"
#include "hal/backends/openni2.hpp"
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
                 hal::open_v4l2, hal::check_v4l2, hal::list_v4l2},
    hal::Backend{"openni2",
                 "PrimeSense, Xtion, Kinect-class devices and .oni files: openni2:, openni2:URI or openni2:FILE.oni",
                 hal::open_openni2, hal::check_openni2, hal::list_openni2},
    hal::Backend{"libusb", "Kinect v1 on USB: libusb: or libusb:SERIAL", hal::open_libusb, hal::check_libusb,
                 hal::list_libusb},
};
}  // namespace

std::span<const hal::Backend> camera_backends() { return kBackends; }

std::string cameras_text(std::span<const hal::CameraInfo> cameras) {
  std::string text, best;
  for (const hal::CameraInfo& camera : cameras) {
    text += fmt::format("{}\n  {}\n", camera.address, camera.description);
    if (!camera.abilities.empty()) text += fmt::format("  {}\n", camera.abilities);
    if (!camera.problem.empty()) text += fmt::format("  cannot be used: {}\n", camera.problem);
    if (camera.problem.empty() && best.empty()) best = camera.address;
  }
  if (cameras.empty()) return "no camera found on this machine; recordings and simulations are named, see --help\n";
  return text + (best.empty() ? "none of them can be used\n" : fmt::format("auto is {}\n", best));
}

}  // namespace onemap::daemon
