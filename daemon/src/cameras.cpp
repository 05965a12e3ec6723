#include "daemon/cameras.hpp"

#include <array>

#include "control/found_cameras.hpp"
#include "hal/backends/libusb.hpp"
#include "hal/backends/openni2.hpp"
#include "hal/backends/replay.hpp"
#include "hal/backends/simulated.hpp"
#include "hal/backends/v4l2.hpp"
#include "hal/base/text.hpp"

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
    hal::Backend{"libusb", "Kinect v1 (Xbox 360 or for Windows) on USB: libusb: or libusb:SERIAL", hal::open_libusb,
                 hal::check_libusb, hal::list_libusb},
};
}  // namespace

std::span<const hal::Backend> camera_backends() { return kBackends; }

namespace {
control::Json found(std::span<const hal::CameraInfo> cameras) {
  control::Json list = control::Json::array();
  for (const hal::CameraInfo& camera : cameras)
    list.push_back({{"address", printable(camera.address)},
                    {"description", printable(camera.description)},
                    {"abilities", printable(camera.abilities)},
                    {"problem", printable(camera.problem)},
                    {"limits", printable(camera.limits)}});
  const hal::CameraInfo* best = hal::best_of(cameras);
  return {{"found", std::move(list)}, {"auto", best ? control::Json(printable(best->address)) : control::Json()}};
}
}  // namespace

std::string cameras_json_text(std::span<const hal::CameraInfo> cameras) { return control::line_of(found(cameras)); }

std::string cameras_text(std::span<const hal::CameraInfo> cameras) {
  return control::found_cameras_words(found(cameras));
}

}  // namespace onemap::daemon
