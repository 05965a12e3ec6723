#include "mapping/team/kept_keyframes.hpp"

namespace onemap::mapping {
namespace {

constexpr std::uint32_t kLargestStep = 1u << 20;

std::size_t cost(const KeptKeyframes::Kept& kept) { return sizeof(kept) + kept.body.size(); }

}  // namespace

void KeptKeyframes::add(const KeyframeRecord& record) {
  if (record.index % step_ != 0) {
    ++left_out_;
    return;
  }
  KeyframeRecord bare;
  bare.index = record.index;
  bare.time = record.time;
  bare.T_robot_keyframe = record.T_robot_keyframe;
  bare.anchor = record.anchor;
  bare.grid = record.grid;
  kept_.push_back({record.index, record.T_robot_keyframe, encode(bare, Packing::quick)});
  bytes_ += cost(kept_.back());
  while (bytes_ > budget_bytes_ && step_ < kLargestStep) thin_out();
}

void KeptKeyframes::thin_out() {
  step_ *= 2;
  left_out_ += std::erase_if(kept_, [&](const Kept& kept) { return kept.index % step_ != 0; });
  bytes_ = 0;
  for (const Kept& kept : kept_) bytes_ += cost(kept);
}

}  // namespace onemap::mapping
