#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/base/bytes.hpp"
#include "hal/base/ids.hpp"
#include "hal/base/result.hpp"
#include "hal/base/time.hpp"
#include "mapping/geometry.hpp"
#include "mapping/local/features.hpp"
#include "mapping/local/voxel_map.hpp"

namespace onemap::mapping {

// The typed bodies of the records that robots exchange (comms sees only bytes). One canonical encoding each: little
// endian, integers only, bounded, versioned by the kind. decode() is total: any bytes give a value or an error that
// names the field; encode(decode(x)) == x. For submaps that holds for the content of the compressed part: the
// compressed bytes themselves may differ between versions of zstd, and every version accepts every other's. encode()
// expects a record that keeps the bounds stated here; what breaks them is refused by decode().
enum class RecordKind : std::uint16_t {
  hello = 1,
  keyframe = 2,
  trajectory = 3,
  submap = 4,
  link = 5,
  solution = 6,
  finished = 7
};

// Lanes keep small and urgent records from waiting behind large ones; lower goes first.
enum class Lane : std::uint8_t { control = 0, poses = 1, features = 2, voxels = 3 };

inline constexpr double kPointUnit_m = 0.00025;  // unit of the int16 points and depths in records: 0.25 mm, so +-8.19 m

struct HelloRecord {   // lane control, first record of a robot
  std::string name;    // 1..16 characters
  std::string camera;  // 0..200 bytes without control characters, for people
};

struct KeyframeFeature {
  std::array<std::int16_t, 3> point{};  // camera frame, units of kPointUnit_m; z > 0
  std::int8_t laplacian = 0;
  Descriptor descriptor;
};

// A depth image on an ideal pinhole grid (see OrganizedCloud), coarse: for ICP between robots.
struct DepthGrid {
  std::uint16_t width = 0, height = 0;        // at most 160 x 120
  std::array<std::int32_t, 4> fx_fy_cx_cy{};  // pixels of this grid, units of 1/1024
  std::vector<std::uint16_t> depth;           // units of kPointUnit_m, 0 = none; row by row
};

struct KeyframeRecord {     // lane features
  std::uint32_t index = 0;  // the robot's own count, from 0
  FrameTime time{};
  QuantizedPose T_robot_keyframe;
  DescriptorKind descriptor_kind = DescriptorKind::surf;
  std::vector<KeyframeFeature> features;  // at most 1000
  DepthGrid grid;
};

struct StampedPose {
  FrameTime time{};
  QuantizedPose T_robot_camera;
};
struct TrajectoryRecord {          // lane poses; consecutive batches
  std::vector<StampedPose> poses;  // at most 4096, times strictly increasing
};

// Surface voxels of a set of blocks, as what fusion needs: tsdf mean and weight and mean colour.
struct SubmapVoxel {
  std::int16_t tsdf = 0;    // mean, in units of truncation / kTsdfOne
  std::uint8_t weight = 0;  // sum of weights, capped at 255; 0 = unseen (then everything else is 0)
  Rgb rgb{};                // mean colour; 0 0 0 = none was seen (black is written as 1 1 1)
};
struct SubmapBlock {
  BlockKey key;
  std::array<SubmapVoxel, kBlockVoxels> voxels{};
};
struct SubmapRecord {                 // lane voxels; blocks sorted by key, no key twice within one submap
  std::uint32_t anchor_keyframe = 0;  // the keyframe whose pose the submap follows (0: the robot's own frame)
  std::int32_t voxel_um = 0;          // micrometres; 1 mm to 1 m
  std::int32_t truncation_um = 0;     // 1 to 100 voxels
  std::vector<SubmapBlock> blocks;    // at most 512; coordinates below 2^20
};

enum class LinkReason : std::uint8_t {
  accepted = 0,
  too_few_matches,
  fundamental_failed,
  depth_incoherent,
  ransac_failed,
  icp_failed,
  inconsistent
};

// A verified (or refused) relation of two robots' maps: the paper's quality ratio and eq. (11).
struct LinkRecord {                                // lane poses
  RobotId a, b;                                    // a < b
  std::uint64_t incarnation_b = 0;                 // whose records of b these were; a's is that of the record's log
  std::uint32_t keyframes_a = 0, keyframes_b = 0;  // so many keyframes of each were looked at
  std::uint32_t keyframe_a = 0, keyframe_b = 0;    // the best pair of clouds r, s
  LinkReason reason = LinkReason::accepted;
  std::uint32_t supporting_pairs = 0;  // pairs of clouds that agree with the transform
  std::uint32_t inliers = 0;           // matched features that agree, over all supporting pairs
  std::uint32_t ratio_e4 = 0;          // quality ratio of the best pair: inliers / features, times 10000
  std::int32_t error_um = 0;           // rms of the supporting pairs' residual
  QuantizedPose T_a_b;                 // ref_a T ref_b
};

struct SolvedRobot {
  RobotId robot;
  QuantizedPose T_global_robot;
};
struct SolutionRecord {             // lane poses; of the elected robot; the last one counts
  RobotId reference;                // the global frame is this robot's own frame
  std::vector<SolvedRobot> robots;  // in the map, sorted by id, the reference among them; at most 1024
  std::uint32_t links_used = 0;
};

struct FinishedRecord {  // lane control: this robot will write nothing more of its own camera
  std::uint32_t frames = 0, tracked = 0, keyframes = 0, submaps = 0;
};

std::vector<std::uint8_t> encode(const HelloRecord&);
std::vector<std::uint8_t> encode(const KeyframeRecord&);
std::vector<std::uint8_t> encode(const TrajectoryRecord&);
std::vector<std::uint8_t> encode(const SubmapRecord&);  // compressed losslessly
std::vector<std::uint8_t> encode(const LinkRecord&);
std::vector<std::uint8_t> encode(const SolutionRecord&);
std::vector<std::uint8_t> encode(const FinishedRecord&);
Result<HelloRecord> decode_hello(std::span<const std::uint8_t> body);
Result<KeyframeRecord> decode_keyframe(std::span<const std::uint8_t> body);
Result<TrajectoryRecord> decode_trajectory(std::span<const std::uint8_t> body);
Result<SubmapRecord> decode_submap(std::span<const std::uint8_t> body);
Result<LinkRecord> decode_link(std::span<const std::uint8_t> body);
Result<SolutionRecord> decode_solution(std::span<const std::uint8_t> body);
Result<FinishedRecord> decode_finished(std::span<const std::uint8_t> body);

}  // namespace onemap::mapping
