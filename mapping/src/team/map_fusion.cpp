#include "mapping/team/map_fusion.hpp"

#include <algorithm>

namespace onemap::mapping {

void MapFusion::begin(const SolutionRecord& solution) {
  if (!atlas_) atlas_ = std::make_unique<Atlas>(config_);
  atlas_->begin(solution);
  solution_ = solution;
  next_ = 0;
  submaps_ = 0;
  submaps_left_out_ = 0;
  added_.clear();
}

bool MapFusion::add(const TeamMember& member, const std::function<bool()>& stop) {
  LatestSubmaps latest(next(), config_.map.budget_bytes / sizeof(SubmapBlock));
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
  atlas_->add(next(), latest.submaps());
  added_.push_back({member.incarnation, member.submaps.size()});
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
    if (log.find(solution_->robots[i].robot)->submaps.size() != added_[i].submaps) return false;
  return true;
}

}  // namespace onemap::mapping
