#include "mapping/team/pose_graph.hpp"

#include <string>
#include <utility>

#include "faults.hpp"

namespace onemap::mapping {

namespace {

std::string place_of(const ChainId& chain, std::uint32_t keyframe) {
  return "pose graph, " + chain.robot.name() + " life " + std::to_string(chain.incarnation) + " keyframe " +
         std::to_string(keyframe);
}

}  // namespace

Status PoseGraph::refuse(Error error) {
  ++refused_;
  return error;
}

Status PoseGraph::set_chain(const ChainId& chain, std::vector<ChainAnchor> anchors) {
  const auto at = chains_.find(chain);
  const std::size_t before = at == chains_.end() ? 0 : at->second.size();
  if (anchors.size() > before && anchor_count_ - before + anchors.size() > config_.max_anchors)
    return refuse({place_of(chain, 0), "the graph holds " + std::to_string(config_.max_anchors) + " anchors"});
  for (std::size_t i = 0; i < anchors.size(); ++i) {
    std::string fault = fault_of(anchors[i]);
    if (fault.empty() && i > 0 && anchors[i].keyframe <= anchors[i - 1].keyframe) fault = "anchors are not ascending";
    if (!fault.empty()) return refuse({place_of(chain, anchors[i].keyframe), std::move(fault)});
  }
  anchor_count_ += anchors.size() - before;
  if (anchors.empty())
    chains_.erase(chain);
  else
    chains_[chain] = std::move(anchors);
  return success();
}

Status PoseGraph::set_anchor(const ChainId& chain, const ChainAnchor& anchor) {
  const auto at = chains_.find(chain);
  const bool again = at != chains_.end() && at->second.back().keyframe == anchor.keyframe;
  std::string fault = fault_of(anchor);
  if (fault.empty() && at != chains_.end() && anchor.keyframe < at->second.back().keyframe)
    fault = "anchors are not ascending";
  if (fault.empty() && !again && anchor_count_ >= config_.max_anchors)
    fault = "the graph holds " + std::to_string(config_.max_anchors) + " anchors";
  if (!fault.empty()) return refuse({place_of(chain, anchor.keyframe), std::move(fault)});
  if (again) {
    at->second.back() = anchor;
  } else {
    chains_[chain].push_back(anchor);
    ++anchor_count_;
  }
  return success();
}

void PoseGraph::remove_chain(const ChainId& chain) {
  const auto at = chains_.find(chain);
  if (at == chains_.end()) return;
  anchor_count_ -= at->second.size();
  chains_.erase(at);
}

Status PoseGraph::set_link(const GraphLink& link) {
  std::string fault = fault_of(link);
  if (fault.empty() && !links_.contains(link.id()) && links_.size() >= config_.max_links)
    fault = "the graph holds " + std::to_string(config_.max_links) + " links";
  if (!fault.empty()) return refuse({place_of(link.b.chain, link.b.keyframe) + ", link", std::move(fault)});
  links_[link.id()] = link;
  return success();
}

void PoseGraph::remove_link(const LinkId& link) { links_.erase(link); }

}  // namespace onemap::mapping
