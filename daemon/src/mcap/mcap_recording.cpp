#include "daemon/mcap/mcap_recording.hpp"

#include "daemon/mcap/foxglove.hpp"
#include "hal/imaging/encode_image.hpp"

namespace onemap::daemon {

namespace {
constexpr int kQuality = 85;
constexpr std::uint64_t kPointsEach = 10;  // frames
constexpr int kPointsStep = 4;             // pixels
}  // namespace

McapRecording::McapRecording(McapWriter writer) : writer_(std::move(writer)) {
  const auto channel = [&](const char* topic, const std::string& schema) {
    return writer_.add_channel(topic, "foxglove." + schema, foxglove_schema(schema));
  };
  image_ = channel("/camera/image", "CompressedImage");
  points_ = channel("/camera/points", "PointCloud");
  tf_ = channel("/tf", "FrameTransform");
  odom_ = channel("/pose/odom", "PoseInFrame");
  map_ = channel("/pose/map", "PoseInFrame");
}

Result<McapRecording> McapRecording::create(const std::string& path) {
  auto writer = McapWriter::create(path, "onemap " ONEMAP_VERSION);
  if (!writer) return writer.error();
  return McapRecording(std::move(*writer));
}

Status McapRecording::write(const hal::FrameView& frame) {
  const auto size = hal::imaging::size_of(*frame.intrinsics);
  if (auto done = hal::imaging::encode_jpeg(size, frame.rgb, kQuality, file_); !done) return done;
  const FrameTime time = frame.colour_time;
  if (auto done = writer_.write(image_, time, compressed_image(time, "jpeg", file_)); !done) return done;
  if (frames_++ % kPointsEach != 0) return success();
  return writer_.write(points_, time, point_cloud(frame, kPointsStep));
}

Status McapRecording::write(const RecordedPose& pose) {
  const auto& [time, T_odom_camera, T_map_odom] = pose;
  if (auto done = writer_.write(odom_, time, pose_in_frame(time, "odom", T_odom_camera)); !done) return done;
  if (auto done = writer_.write(tf_, time, frame_transform(time, "odom", "camera", T_odom_camera)); !done) return done;
  if (!T_map_odom) return success();
  const mapping::Pose T_map_camera = *T_map_odom * T_odom_camera;
  if (auto done = writer_.write(map_, time, pose_in_frame(time, "map", T_map_camera)); !done) return done;
  return writer_.write(tf_, time, frame_transform(time, "map", "odom", *T_map_odom));
}

}  // namespace onemap::daemon
