#include "mapping/local/missing_blocks.hpp"

#include <bit>

namespace onemap::mapping {

namespace {
std::size_t slots_for(std::size_t most) { return std::bit_ceil(2 * most); }
}  // namespace

MissingBlocks::MissingBlocks(std::size_t most) : most_(most), slots_(slots_for(most)) {}

std::size_t MissingBlocks::bytes_for(std::size_t most) { return slots_for(most) * sizeof(Slot); }

void MissingBlocks::begin_frame() {
  ++frame_;
  count_ = 0;
}

bool MissingBlocks::add(const BlockKey& key) {
  const std::size_t mask = slots_.size() - 1;
  std::size_t at = hash(key) & mask;
  for (; slots_[at].frame == frame_; at = (at + 1) & mask)
    if (slots_[at].key == key) return false;
  if (count_ == most_) return false;
  slots_[at] = {key, frame_};
  ++count_;
  return true;
}

}  // namespace onemap::mapping
