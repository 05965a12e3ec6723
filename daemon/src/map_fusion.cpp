#include "daemon/map_fusion.hpp"

#include <algorithm>

namespace onemap::daemon {

void MapFusion::begin(const mapping::SolutionRecord& solution) {
  if (!atlas_) atlas_ = std::make_unique<mapping::Atlas>(config_);
  atlas_->begin(solution);
  solution_ = solution;
  next_ = 0;
  submaps_ = 0;
}

bool MapFusion::add(const TeamMember& member, const std::function<bool()>& stop) {
  mapping::LatestSubmaps latest(next());
  for (auto record = member.submaps.rbegin(); record != member.submaps.rend(); ++record) {
    if (stop()) return false;
    auto submap = mapping::decode_submap((*record)->body);  // cannot fail: members keep what decodes
    if (submap) latest.add_older((*record)->id.seq, std::move(*submap));
  }
  atlas_->add(next(), latest.submaps());
  submaps_ += member.submaps.size();
  ++next_;
  return true;
}

}  // namespace onemap::daemon
