#include "daemon/mcap/foxglove.hpp"

#include <fmt/format.h>

#include <bit>

#include "hal/base/bytes.hpp"

namespace onemap::daemon {

namespace {

constexpr const char* kCamera = "camera";

std::string time_json(FrameTime time) {
  const std::int64_t ns = time.time_since_epoch().count();
  return fmt::format(R"({{"sec":{},"nsec":{}}})", ns / 1'000'000'000, ns % 1'000'000'000);
}

std::string vector_json(const mapping::Vector3d& v) {
  return fmt::format(R"({{"x":{:.6f},"y":{:.6f},"z":{:.6f}}})", v.x(), v.y(), v.z());
}

std::string rotation_json(const mapping::Matrix3d& R) {
  const auto q = mapping::to_quaternion_wxyz(R);
  return fmt::format(R"({{"x":{:.9f},"y":{:.9f},"z":{:.9f},"w":{:.9f}}})", q[1], q[2], q[3], q[0]);
}

std::string pose_json(const mapping::Pose& T) {
  return fmt::format(R"({{"position":{},"orientation":{}}})", vector_json(T.t), rotation_json(T.R));
}

// Schemas in as few words as they need.
std::string object(const std::string& title, const std::string& properties) {
  return fmt::format(R"({{"title":"{}","type":"object","properties":{{{}}}}})", title, properties);
}
const std::string kInteger = R"({"type":"integer","minimum":0})", kNumber = R"({"type":"number"})",
                  kString = R"({"type":"string"})", kData = R"({"type":"string","contentEncoding":"base64"})";

std::string property(const std::string& name, const std::string& what) { return "\"" + name + "\":" + what; }

std::string stamped() {
  return property("timestamp", object("time", property("sec", kInteger) + "," + property("nsec", kInteger))) + ",";
}
std::string vector_schema() {
  return object("foxglove.Vector3",
                property("x", kNumber) + "," + property("y", kNumber) + "," + property("z", kNumber));
}
std::string rotation_schema() {
  return object("foxglove.Quaternion", property("x", kNumber) + "," + property("y", kNumber) + "," +
                                           property("z", kNumber) + "," + property("w", kNumber));
}
std::string pose_schema() {
  return object("foxglove.Pose",
                property("position", vector_schema()) + "," + property("orientation", rotation_schema()));
}
std::string fields_schema() {
  return fmt::format(
      R"({{"type":"array","items":{}}})",
      object("foxglove.PackedElementField",
             property("name", kString) + "," + property("offset", kInteger) + "," + property("type", kInteger)));
}

constexpr int kFloat = 7, kByte = 1;  // foxglove.NumericType

void put_float(ByteWriter& out, double value) { out.put(std::bit_cast<std::uint32_t>(static_cast<float>(value))); }

std::vector<std::uint8_t> points_of(const hal::FrameView& frame, int step) {
  const hal::Intrinsics& k = *frame.intrinsics;
  std::vector<std::uint8_t> bytes;
  ByteWriter out(bytes);
  for (int y = 0; y < k.height; y += step)
    for (int x = 0; x < k.width; x += step) {
      const std::size_t at =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(k.width) + static_cast<std::size_t>(x);
      if (frame.depth[at] == 0) continue;
      const double z = frame.depth[at] / k.depth_scale;
      put_float(out, z * (x - k.cx) / k.fx);
      put_float(out, z * (y - k.cy) / k.fy);
      put_float(out, z);
      out.bytes(frame.rgb.subspan(3 * at, 3));
      out.put(std::uint8_t{255});
    }
  return bytes;
}

}  // namespace

std::string foxglove_schema(std::string_view name) {
  const std::string title = "foxglove." + std::string(name);
  if (name == "FrameTransform")
    return object(title, stamped() + property("parent_frame_id", kString) + "," + property("child_frame_id", kString) +
                             "," + property("translation", vector_schema()) + "," +
                             property("rotation", rotation_schema()));
  const std::string in_frame = stamped() + property("frame_id", kString) + ",";
  if (name == "PoseInFrame") return object(title, in_frame + property("pose", pose_schema()));
  if (name == "CompressedImage")
    return object(title, in_frame + property("data", kData) + "," + property("format", kString));
  return object(title, in_frame + property("pose", pose_schema()) + "," + property("point_stride", kInteger) + "," +
                           property("fields", fields_schema()) + "," + property("data", kData));
}

std::string base64(std::span<const std::uint8_t> bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t n = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t v = 0;
    for (std::size_t k = 0; k < 3; ++k) v = (v << 8) | (k < n ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= n ? kDigits[(v >> (18 - 6 * k)) & 63] : '=';
  }
  return text;
}

std::string frame_transform(FrameTime time, std::string_view parent, std::string_view child, const mapping::Pose& T) {
  return fmt::format(
      R"({{"timestamp":{},"parent_frame_id":"{}","child_frame_id":"{}","translation":{},"rotation":{}}})",
      time_json(time), parent, child, vector_json(T.t), rotation_json(T.R));
}

std::string pose_in_frame(FrameTime time, std::string_view frame, const mapping::Pose& T) {
  return fmt::format(R"({{"timestamp":{},"frame_id":"{}","pose":{}}})", time_json(time), frame, pose_json(T));
}

std::string compressed_image(FrameTime time, std::string_view format, std::span<const std::uint8_t> file) {
  return fmt::format(R"({{"timestamp":{},"frame_id":"{}","format":"{}","data":"{}"}})", time_json(time), kCamera,
                     format, base64(file));
}

std::string point_cloud(const hal::FrameView& frame, int step) {
  std::string fields;
  int offset = 0;
  for (const char* name : {"x", "y", "z", "red", "green", "blue", "alpha"}) {
    const bool coordinate = offset < 12;
    fields += fmt::format(R"({}{{"name":"{}","offset":{},"type":{}}})", fields.empty() ? "" : ",", name, offset,
                          coordinate ? kFloat : kByte);
    offset += coordinate ? 4 : 1;
  }
  return fmt::format(R"({{"timestamp":{},"frame_id":"{}","pose":{},"point_stride":{},"fields":[{}],"data":"{}"}})",
                     time_json(frame.colour_time), kCamera, pose_json({}), offset, fields,
                     base64(points_of(frame, step)));
}

}  // namespace onemap::daemon
