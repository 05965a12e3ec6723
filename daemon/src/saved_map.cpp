// A saved map: "onemap", a zero and the format's version; then sections of tag u8, size u32, content, all little
// endian:
//   1 voxel size and truncation in micrometres, number of blocks (u32 each); 2 title; 3 path: name (u8 length), colour
//   3 x u8, T_map_robot, number of poses u32, poses, number of keyframes u32, keyframes (each pose 7 x i32);
//   4 a submap body, in the order of the blocks; 5 which way is up: a unit vector in millionths (3 x i32). The last
//   section is 0, empty.
#include "daemon/saved_map.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "hal/base/bytes.hpp"
#include "hal/base/text.hpp"
#include "mapping/local/surface.hpp"
#include "mapping/team/atlas.hpp"

namespace onemap::daemon {

namespace {

constexpr std::array<std::uint8_t, 8> kMagic{'o', 'n', 'e', 'm', 'a', 'p', 0, 1};
enum class Tag : std::uint8_t { end = 0, grid = 1, title = 2, path = 3, submap = 4, up = 5 };
constexpr std::size_t kBlocksAtOnce = 256;
constexpr std::size_t kPoseBytes = 28;
constexpr std::uint32_t kMostBlocks = 8u << 20;

void put_section(std::vector<std::uint8_t>& out, Tag tag, std::span<const std::uint8_t> content) {
  ByteWriter writer(out);
  writer.put(static_cast<std::uint8_t>(tag));
  writer.put(static_cast<std::uint32_t>(content.size()));
  writer.bytes(content);
}

void put_pose(ByteWriter& out, const mapping::QuantizedPose& pose) {
  for (const std::int32_t v : pose.t_10um) out.put(v);
  for (const std::int32_t v : pose.q_wxyz) out.put(v);
}

void put_poses(ByteWriter& out, const std::vector<mapping::QuantizedPose>& poses) {
  out.put(static_cast<std::uint32_t>(poses.size()));
  for (const mapping::QuantizedPose& pose : poses) put_pose(out, pose);
}

std::vector<std::uint8_t> path_section(const SavedPath& path) {
  std::vector<std::uint8_t> out;
  ByteWriter writer(out);
  const std::string name = path.name.substr(0, 255);
  writer.put(static_cast<std::uint8_t>(name.size()));
  writer.bytes({reinterpret_cast<const std::uint8_t*>(name.data()), name.size()});
  writer.bytes(path.color);
  put_pose(writer, path.T_map_robot);
  put_poses(writer, path.poses);
  put_poses(writer, path.keyframes);
  return out;
}

std::vector<std::uint8_t> grid_section(const mapping::VoxelMap& map) {
  std::vector<std::uint8_t> out;
  ByteWriter writer(out);
  writer.put(static_cast<std::uint32_t>(map.config().voxel_um()));
  writer.put(static_cast<std::uint32_t>(map.config().truncation_um()));
  writer.put(static_cast<std::uint32_t>(map.used()));
  return out;
}

std::vector<std::uint8_t> up_section(const mapping::UpDirection& up) {
  std::vector<std::uint8_t> out;
  ByteWriter writer(out);
  for (const std::int32_t v : up.millionths) writer.put(v);
  return out;
}

void put_blocks(std::vector<std::uint8_t>& out, const mapping::VoxelMap& map) {
  std::vector<mapping::BlockKey> keys;
  const auto flush = [&] {
    if (!keys.empty()) put_section(out, Tag::submap, encode(mapping::make_submap(map, keys)));
    keys.clear();
  };
  map.for_each_sorted([&](const mapping::BlockView& block) {
    keys.push_back(block.key);
    if (keys.size() == kBlocksAtOnce) flush();
  });
  flush();
}

struct Section {
  Tag tag = Tag::end;
  std::span<const std::uint8_t> content;
};

std::string text_of(std::span<const std::uint8_t> bytes) {
  return printable(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

mapping::QuantizedPose get_pose(ByteReader& in) {
  mapping::QuantizedPose pose;
  for (std::int32_t& v : pose.t_10um) v = in.get<std::int32_t>();
  for (std::int32_t& v : pose.q_wxyz) v = in.get<std::int32_t>();
  return pose;
}

// A quaternion of no length is no rotation.
bool is_rotation(const mapping::QuantizedPose& pose) {
  double norm = 0;
  for (const std::int32_t v : pose.q_wxyz) norm += static_cast<double>(v) * v;
  const double one = static_cast<double>(1 << 30) * (1 << 30);
  return norm > 0.99 * one && norm < 1.01 * one;
}

bool get_poses(ByteReader& in, const mapping::Pose& T_map_robot, std::vector<mapping::Pose>& out) {
  const auto count = in.get<std::uint32_t>();
  if (count > in.remaining() / kPoseBytes) return false;
  for (std::uint32_t i = 0; i < count; ++i) {
    const mapping::QuantizedPose pose = get_pose(in);
    if (!is_rotation(pose)) return false;
    out.push_back(T_map_robot * mapping::from_quantized(pose));
  }
  return in.ok();
}

class Loader {
 public:
  explicit Loader(const std::string& place) : place_(place) {}

  Result<render::Scene> load(std::span<const std::uint8_t> bytes) {
    const std::size_t magic = std::min(bytes.size(), kMagic.size());
    if (magic < kMagic.size() || !std::equal(kMagic.begin(), kMagic.end(), bytes.begin()))
      return Error{place_, "not a saved map of onemap, version 1"};
    ByteReader in(bytes.subspan(magic));
    for (;;) {
      const auto tag = static_cast<Tag>(in.get<std::uint8_t>());
      const auto size = in.get<std::uint32_t>();
      const Section section{tag, in.bytes(size)};
      if (!in.ok()) return Error{place_, "ends in the middle"};
      if (tag == Tag::end) break;
      if (auto taken = take(section); !taken) return taken.error();
    }
    if (!in.done()) return Error{place_, "goes on after its end"};
    if (voxel_um_ == 0) return Error{place_, "says no voxel size"};
    scene_.mesh = mesher_->take();
    return std::move(scene_);
  }

 private:
  Status take(const Section& section) {
    switch (section.tag) {
      case Tag::grid:
        return take_grid(section.content);
      case Tag::title:
        scene_.title = text_of(section.content);
        return success();
      case Tag::path:
        return take_path(section.content);
      case Tag::submap:
        return take_submap(section.content);
      case Tag::up:
        return take_up(section.content);
      case Tag::end:
        break;
    }
    return Error{place_, "a section of an unknown kind"};
  }

  Status take_grid(std::span<const std::uint8_t> content) {
    ByteReader in(content);
    const auto voxel = in.get<std::uint32_t>(), truncation = in.get<std::uint32_t>();
    const auto blocks = in.get<std::uint32_t>();
    const bool good = in.done() && voxel >= 1000 && voxel <= 1'000'000 && truncation >= voxel &&
                      truncation <= 100 * voxel && blocks <= kMostBlocks;
    if (!good || voxel_um_ != 0) return Error{place_, "a voxel size that cannot be"};
    voxel_um_ = static_cast<std::int32_t>(voxel);
    most_blocks_ = blocks;
    mesher_.emplace(static_cast<float>(voxel_um_ * 1e-6));
    return success();
  }

  Status take_path(std::span<const std::uint8_t> content) {
    ByteReader in(content);
    render::RobotPath path;
    const std::size_t length = in.get<std::uint8_t>();
    path.name = text_of(in.bytes(length));
    for (std::uint8_t& c : path.color) c = in.get<std::uint8_t>();
    const mapping::QuantizedPose T_map_robot = get_pose(in);
    const bool good = in.ok() && is_rotation(T_map_robot) &&
                      get_poses(in, mapping::from_quantized(T_map_robot), path.poses) &&
                      get_poses(in, mapping::from_quantized(T_map_robot), path.keyframe_poses) && in.done();
    if (!good) return Error{place_, "a robot's way that cannot be read"};
    scene_.robots.push_back(std::move(path));
    return success();
  }

  Status take_up(std::span<const std::uint8_t> content) {
    ByteReader in(content);
    mapping::Vector3d up;
    for (double& v : up) v = in.get<std::int32_t>() * 1e-6;
    const double squared = up.squaredNorm();
    if (!in.done() || !(squared > 0.99 && squared < 1.01)) return Error{place_, "a way up that cannot be"};
    scene_.up = up.normalized().cast<float>();
    return success();
  }

  Status take_submap(std::span<const std::uint8_t> content) {
    if (voxel_um_ == 0) return Error{place_, "a submap before the voxel size"};
    auto record = mapping::decode_submap(content);
    if (!record) return Error{place_, record.error().text()};
    if (record->voxel_um != voxel_um_) return Error{place_, "a submap of another voxel size"};
    blocks_ += record->blocks.size();
    if (blocks_ > most_blocks_) return Error{place_, "more blocks than it said"};
    if (!mesher_->add(std::move(record->blocks))) return Error{place_, "a block that is there twice, or out of order"};
    return success();
  }

  const std::string& place_;
  std::int32_t voxel_um_ = 0;  // 0: not said yet
  std::size_t most_blocks_ = 0, blocks_ = 0;
  std::optional<mapping::BlockMesher> mesher_;  // once the voxel size is known
  render::Scene scene_;
};

}  // namespace

std::vector<std::uint8_t> save_map(const std::string& title, std::span<const SavedPath> paths,
                                   const mapping::VoxelMap& map, const std::optional<mapping::UpDirection>& up) {
  std::vector<std::uint8_t> out(kMagic.begin(), kMagic.end());
  put_section(out, Tag::grid, grid_section(map));
  put_section(out, Tag::title, {reinterpret_cast<const std::uint8_t*>(title.data()), title.size()});
  if (up) put_section(out, Tag::up, up_section(*up));
  for (const SavedPath& path : paths) put_section(out, Tag::path, path_section(path));
  put_blocks(out, map);
  put_section(out, Tag::end, {});
  return out;
}

Result<render::Scene> load_map(const std::string& place, std::span<const std::uint8_t> bytes) {
  return Loader(place).load(bytes);
}

}  // namespace onemap::daemon
