#include "fetch/assembly.hpp"

#include <algorithm>

namespace onemap::comms {

void Assembly::begin(std::uint32_t guessed_fragments) {
  fragments_.assign(guessed_fragments, kMissing);
  known_ = false;
  here_ = 0;
  hops_ = 0;
  missing_ = guessed_fragments;
}

bool Assembly::agrees(const wire::Data& data) const {
  return kind_ == data.kind && total_bytes_ == data.total_bytes && hash_ == data.body_hash;
}

void Assembly::learn(const wire::Data& data) {
  known_ = true;
  kind_ = data.kind;
  total_bytes_ = data.total_bytes;
  hash_ = data.body_hash;
  fragments_.resize(wire::fragments_of(data.total_bytes), kMissing);
  body_.resize(data.total_bytes);
  count_missing();
}

void Assembly::restart() { begin(fragments()); }

void Assembly::asked(std::uint32_t fragment, std::uint32_t serial) {
  fragments_[fragment] = serial;
  --missing_;
}

void Assembly::lost(std::uint32_t fragment) {
  if (fragment >= fragments_.size() || !serial_of(fragment)) return;
  fragments_[fragment] = kMissing;
  ++missing_;
}

void Assembly::withdrawn() {
  for (std::uint32_t& state : fragments_)
    if (state != kHere) state = kMissing;
  count_missing();
}

Assembly::Kept Assembly::keep(const wire::Data& data) {
  std::uint32_t& state = fragments_[data.fragment];
  if (state == kHere) return Kept::again;
  if (state == kMissing) --missing_;
  state = kHere;
  ++here_;
  std::copy(data.bytes.begin(), data.bytes.end(),
            body_.begin() + static_cast<std::ptrdiff_t>(data.fragment * wire::kFragmentBytes));
  hops_ = std::max<std::uint8_t>(hops_, static_cast<std::uint8_t>(std::min(data.hops + 1, 255)));
  return Kept::first;
}

std::optional<std::uint32_t> Assembly::serial_of(std::uint32_t fragment) const {
  const std::uint32_t state = fragments_[fragment];
  return state == kMissing || state == kHere ? std::nullopt : std::optional(state);
}

void Assembly::count_missing() {
  missing_ = static_cast<std::uint32_t>(std::count(fragments_.begin(), fragments_.end(), kMissing));
}

}  // namespace onemap::comms
