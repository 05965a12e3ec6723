#include "mapping/team/map_fusion.hpp"

#include <xxhash.h>

#include "hal/base/bytes.hpp"
#include "mapping/team/placed_anchors.hpp"

namespace onemap::mapping {

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
  atlas_->add(placed_anchors(member, solution_->robots[next_]), latest.submaps());
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
  SolutionRecord named = *solution_;
  for (SolvedRobot& robot : named.robots) robot.incarnation = 0;
  std::vector<std::uint8_t> bytes = encode(named);
  ByteWriter(bytes).put(atlas_->map().digest());
  return XXH64(bytes.data(), bytes.size(), 0);
}

}  // namespace onemap::mapping
