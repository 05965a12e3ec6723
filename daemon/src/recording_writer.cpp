#include "daemon/recording_writer.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <filesystem>
#include <system_error>
#include <utility>

#include "daemon/outputs.hpp"
#include "hal/backends/replay.hpp"
#include "hal/backends/simulated.hpp"
#include "hal/base/file.hpp"
#include "hal/base/text.hpp"
#include "hal/imaging/encode_image.hpp"

namespace onemap::daemon {

namespace {

// All nine digits: times come back as they were.
std::string time_text(FrameTime time) {
  const std::int64_t ns = time.time_since_epoch().count();
  return fmt::format("{}.{:09}", ns / 1'000'000'000, ns % 1'000'000'000);
}

std::string calibration_text(const RecordedCamera& camera) {
  const hal::Intrinsics& k = camera.intrinsics;
  const hal::DepthNoise& noise = camera.noise;
  return fmt::format(
      "# {}\nfx {}\nfy {}\ncx {}\ncy {}\nk1 {}\nk2 {}\np1 {}\np2 {}\nk3 {}\ndepth_scale {}\n"
      "noise_least_m {}\nnoise_growth_per_m {}\nnoise_best_m {}\n",
      printable(camera.description), k.fx, k.fy, k.cx, k.cy, k.k1, k.k2, k.p1, k.p2, k.k3, RecordingWriter::kDepthScale,
      noise.least_m, noise.growth_per_m, noise.best_m);
}

Error failed(const std::string& path, const char* what, int code) {
  return Error{path, fmt::format("{}: {}", what, std::generic_category().message(code))};
}

}  // namespace

TruthLine truth_of(const std::string& camera_address) {
  const auto address = hal::parse_camera_address(camera_address);
  if (!address || address->backend != "simulated") return {};
  auto pose = hal::simulated_pose(*address);
  if (!pose) return {};
  return [pose = std::move(*pose)](const hal::FrameView& frame) -> std::optional<std::string> {
    const hal::SimulatedPose p = pose(frame.index);
    const auto& [x, y, z] = p.t_world_camera_m;
    const auto& q = p.q_world_camera_xyzw;
    return fmt::format("{:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}", x, y, z, q[0], q[1], q[2], q[3]);
  };
}

RecordingWriter::RecordingWriter(RecordingWriter&& other) noexcept
    : folder_(std::move(other.folder_)),
      truth_(std::move(other.truth_)),
      rgb_list_(std::exchange(other.rgb_list_, -1)),
      depth_list_(std::exchange(other.depth_list_, -1)),
      truth_list_(std::exchange(other.truth_list_, -1)),
      file_(std::move(other.file_)),
      depth_(std::move(other.depth_)),
      bytes_(other.bytes_),
      frames_(other.frames_) {}

RecordingWriter::~RecordingWriter() {
  for (const int list : {rgb_list_, depth_list_, truth_list_})
    if (list >= 0) ::close(list);
}

RecordedCamera recorded(const hal::DepthCamera& camera) {
  return {camera.intrinsics(), camera.depth_noise(), camera.description()};
}

Result<RecordingWriter> RecordingWriter::open(const std::string& folder, const RecordedCamera& camera,
                                              TruthLine truth) {
  RecordingWriter writer(folder, std::move(truth));
  if (auto begun = writer.begin(camera); !begun) return begun.error();
  return Result<RecordingWriter>(std::move(writer));
}

Status RecordingWriter::begin(const RecordedCamera& camera) {
  const hal::Intrinsics& intrinsics = camera.intrinsics;
  for (const char* below : {"/rgb", "/depth"})
    if (auto made = make_folder(folder_ + below); !made) return made.error();
  // The first list is the one that says whose folder this is.
  if (auto begun = begin_list(rgb_list_, "rgb.txt", "# colour images\n# timestamp filename\n"); !begun) return begun;
  if (auto begun = begin_list(depth_list_, "depth.txt", std::string(hal::kOwnDepthTime) + "\n# timestamp filename\n");
      !begun)
    return begun;
  if (truth_)
    if (auto begun = begin_list(truth_list_, "groundtruth.txt", "# timestamp tx ty tz qx qy qz qw\n"); !begun)
      return begun;
  depth_.reserve(static_cast<std::size_t>(intrinsics.width) * static_cast<std::size_t>(intrinsics.height));
  return write_text_file(folder_ + "/calibration.txt", calibration_text(camera));
}

Status RecordingWriter::begin_list(int& list, const std::string& name, const std::string& head) {
  const std::string path = folder_ + "/" + name;
  list = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0666);
  if (list < 0 && errno == EEXIST) return Error{folder_, "holds a recording already: name another folder"};
  if (list < 0) return failed(path, "cannot write", errno);
  return append(list, head);
}

Status RecordingWriter::append(int list, const std::string& line) {
  const ssize_t n = ::write(list, line.data(), line.size());
  if (n < 0) return failed(folder_, "cannot write", errno);
  bytes_ += static_cast<std::uint64_t>(n);
  if (static_cast<std::size_t>(n) == line.size()) return success();
  const off_t end = ::lseek(list, 0, SEEK_CUR);  // half a line is none
  [[maybe_unused]] const int cut = ::ftruncate(list, end - n);
  return failed(folder_, "cannot write", ENOSPC);
}

Status RecordingWriter::put(const std::string& name) {
  if (auto written = write_file(folder_ + "/" + name, file_, Durable::no); !written) return written;
  bytes_ += file_.size();
  return success();
}

std::span<const std::uint16_t> RecordingWriter::scaled(const hal::FrameView& frame) {
  const double scale = kDepthScale / frame.intrinsics->depth_scale;
  if (scale == 1) return frame.depth;
  depth_.clear();
  for (const std::uint16_t value : frame.depth) {
    const double there = std::nearbyint(value * scale);
    depth_.push_back(there > 65535 ? std::uint16_t{0} : static_cast<std::uint16_t>(there));
  }
  return depth_;
}

Status RecordingWriter::write(const hal::FrameView& frame) {
  const auto size = hal::imaging::size_of(*frame.intrinsics);
  const std::string colour_time = time_text(frame.colour_time), depth_time = time_text(frame.depth_time);
  const std::string rgb = "rgb/" + colour_time + ".png", depth = "depth/" + depth_time + ".png";
  if (auto done = hal::imaging::encode_depth(size, scaled(frame), file_); !done)
    return Error{folder_ + "/" + depth, done.error().reason};
  if (auto done = put(depth); !done) return done;
  if (auto done = hal::imaging::encode_colour(size, frame.rgb, file_); !done)
    return Error{folder_ + "/" + rgb, done.error().reason};
  if (auto done = put(rgb); !done) return done;
  if (truth_list_ >= 0)
    if (const auto truth = truth_(frame))
      if (auto done = append(truth_list_, colour_time + " " + *truth + "\n"); !done) return done;
  if (auto done = append(depth_list_, depth_time + " " + depth + "\n"); !done) return done;
  if (auto done = append(rgb_list_, colour_time + " " + rgb + "\n"); !done) return done;
  ++frames_;
  return success();
}

}  // namespace onemap::daemon
