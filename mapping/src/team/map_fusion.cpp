#include "mapping/team/map_fusion.hpp"

#include <xxhash.h>

#include <algorithm>

#include "hal/base/bytes.hpp"

namespace onemap::mapping {

namespace {

// Where the robot's anchors are; of keyframes that claim one number the first counts.
std::vector<PlacedAnchor> placed_anchors(const TeamMember& member, const QuantizedPose& T_global_robot) {
  const Pose T = from_quantized(T_global_robot);
  std::vector<PlacedAnchor> out;
  for (const KeyframePlace& k : member.places)
    if (k.index == k.anchor) out.push_back({k.index, quantize(T * from_quantized(k.T_robot_keyframe))});
  std::ranges::stable_sort(out, {}, &PlacedAnchor::keyframe);
  const auto same = [](const PlacedAnchor& a, const PlacedAnchor& b) { return a.keyframe == b.keyframe; };
  out.erase(std::unique(out.begin(), out.end(), same), out.end());
  return out;
}

}  // namespace

void MapFusion::begin(const SolutionRecord& solution) {
  if (!atlas_) atlas_ = std::make_unique<Atlas>(config_);
  atlas_->clear();
  solution_ = solution;
  next_ = 0;
  submaps_ = 0;
  submaps_left_out_ = 0;
  added_.clear();
}

bool MapFusion::add(const TeamMember& member, const std::function<bool()>& stop) {
  LatestSubmaps latest(config_.map.budget_bytes / sizeof(SubmapBlock));
  std::vector<Malformed> malformed;
  std::size_t left_out = 0;
  for (auto record = member.submaps.rbegin(); record != member.submaps.rend(); ++record) {
    if (stop()) return false;
    const auto header = decode_submap_header((*record)->body);
    if (header && !latest.has_room(header->blocks)) {
      ++left_out;
      continue;
    }
    auto submap = decode_submap((*record)->body);
    if (submap)
      latest.add_older((*record)->id.seq, std::move(*submap));
    else
      malformed.push_back({(*record)->id, submap.error().text()});
  }
  atlas_->add(placed_anchors(member, solution_->robots[next_].T_global_robot), latest.submaps());
  added_.push_back({member.incarnation, member.submaps.size(), member.keyframes.size()});
  malformed_.insert(malformed_.end(), malformed.begin(), malformed.end());
  submaps_ += member.submaps.size();
  submaps_left_out_ += left_out;
  ++next_;
  return true;
}

bool MapFusion::outdated(const TeamLog& log) const {
  for (std::size_t i = 0; i < added_.size(); ++i)
    if (const TeamMember* member = log.find(solution_->robots[i].robot);
        member == nullptr || member->incarnation != added_[i].incarnation)
      return true;
  return false;
}

bool MapFusion::complete(const TeamLog& log) const {
  if (!done() || outdated(log)) return false;
  for (std::size_t i = 0; i < added_.size(); ++i)
    if (const TeamMember& member = *log.find(solution_->robots[i].robot);
        member.submaps.size() != added_[i].submaps || member.keyframes.size() != added_[i].keyframes)
      return false;
  return true;
}

std::uint64_t MapFusion::digest() const {
  if (!done()) return 0;
  std::vector<std::uint8_t> bytes = encode(*solution_);
  ByteWriter(bytes).put(atlas_->map().digest());
  return XXH64(bytes.data(), bytes.size(), 0);
}

}  // namespace onemap::mapping
