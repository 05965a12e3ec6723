#include "daemon/outputs.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <filesystem>

#include "hal/base/text.hpp"
#include "mapping/local/surface.hpp"
#include "render/camera.hpp"
#include "render/file.hpp"
#include "render/gltf_writer.hpp"
#include "render/legend.hpp"
#include "render/ply_writer.hpp"
#include "render/png_writer.hpp"
#include "render/renderer.hpp"
#include "render/tidy.hpp"
#include "render/upright.hpp"

namespace onemap::daemon {

namespace {

std::string time_text(FrameTime time) {
  const std::int64_t us = (time.time_since_epoch().count() + 500) / 1000;  // recordings have whole microseconds
  return fmt::format("{}.{:06}", us / 1000000, us % 1000000);
}

Status draw(MapPicture& picture, render::Renderer& renderer) {
  picture.scene.mesh = render::tidied(mapping::extract_mesh(*picture.map));
  const mapping::Matrix3d R = render::upright_rotation(render::up_of(picture.scene));
  if (auto status = render::write_ply(picture.stem + ".ply", picture.scene.mesh, R); !status) return status;
  if (auto status = render::write_glb(picture.stem + ".glb", picture.scene); !status) return status;
  const render::Style style;
  const float aspect = static_cast<float>(style.width_px) / static_cast<float>(style.height_px);
  auto image = render::take_picture(renderer, picture.scene,
                                    render::make_camera(picture.scene, render::View::fit, aspect), style);
  if (!image) return image.error();
  return render::write_png(picture.stem + ".png", *image);
}

// Says through `sizes` what each picture holds when it is written.
Status draw_all(std::vector<MapPicture>& pictures, int sizes) {
  auto renderer = render::open_egl_renderer();
  if (!renderer) return renderer.error();
  for (MapPicture& picture : pictures) {
    if (auto status = draw(picture, **renderer); !status) return status;
    const PictureSize size{picture.scene.mesh.vertices.size()};
    if (write(sizes, &size, sizeof size) != sizeof size) return Error{picture.stem, "cannot tell its size"};
    picture.scene = {};
  }
  return success();
}

Status wait_for(pid_t child) {
  int result = 0;
  while (waitpid(child, &result, 0) < 0)
    if (errno != EINTR) return Error{"pictures", std::string("waitpid: ") + std::strerror(errno)};
  if (WIFSIGNALED(result)) return Error{"pictures", fmt::format("drawing ended by signal {}", WTERMSIG(result))};
  if (WEXITSTATUS(result) != 0) return Error{"pictures", "not written, see above"};
  return success();
}

}  // namespace

std::string trajectory_text(const std::vector<mapping::StampedPose>& poses, const mapping::Pose& T_frame_robot) {
  std::string text;
  for (const mapping::StampedPose& stamped : poses) {
    const mapping::Pose T = T_frame_robot * mapping::from_quantized(stamped.T_robot_camera);
    const auto q = mapping::to_quaternion_wxyz(T.R);
    text += fmt::format("{} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n", time_text(stamped.time), T.t.x(),
                        T.t.y(), T.t.z(), q[1], q[2], q[3], q[0]);
  }
  return text;
}

Status write_text(const std::string& file, const std::string& text) {
  return render::write_file(file, std::vector<std::uint8_t>(text.begin(), text.end()));
}

Status make_folder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return Error{folder, "cannot make the folder: " + error.message()};
  return success();
}

render::RobotPath make_path(const std::string& name, render::Color color,
                            const std::vector<mapping::StampedPose>& poses,
                            const std::vector<mapping::QuantizedPose>& keyframes, const mapping::Pose& T_scene_robot) {
  render::RobotPath path{name, color, {}, {}};
  for (const mapping::StampedPose& pose : poses)
    path.poses.push_back(T_scene_robot * mapping::from_quantized(pose.T_robot_camera));
  for (const mapping::QuantizedPose& pose : keyframes)
    path.keyframe_poses.push_back(T_scene_robot * mapping::from_quantized(pose));
  return path;
}

Status write_pictures(std::vector<MapPicture> pictures, std::vector<PictureSize>& sizes) {
  std::fflush(nullptr);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return Error{"pictures", std::string("pipe: ") + std::strerror(errno)};
  const pid_t child = fork();
  if (child == 0) {
    const Status status = draw_all(pictures, ends[1]);
    if (!status) fmt::print(stderr, "pictures: {}\n", printable(status.error().text()));
    std::fflush(nullptr);
    _exit(status ? 0 : 1);
  }
  const int error = errno;
  close(ends[1]);
  if (child < 0) return close(ends[0]), Error{"pictures", std::string("fork: ") + std::strerror(error)};
  PictureSize size;
  while (sizes.size() < pictures.size() && read(ends[0], &size, sizeof size) == sizeof size) sizes.push_back(size);
  close(ends[0]);
  return wait_for(child);
}

}  // namespace onemap::daemon
