#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

#include "hal/base/record.hpp"
#include "memory/memory.hpp"

namespace onemap::comms {

// Something about each of some logs: found by a hash, gone through in the order in which the logs came. What is asked
// of it for every log that anybody names must not cost a walk down a tree.
template <class T>
class LogMap {
 public:
  using Entry = std::pair<LogId, T>;
  explicit LogMap(Memory& memory = heap()) : entries_(&memory), slots_(&memory) {}

  std::size_t size() const { return entries_.size(); }
  auto begin() { return entries_.begin(); }
  auto end() { return entries_.end(); }
  auto begin() const { return entries_.begin(); }
  auto end() const { return entries_.end(); }
  const T* find(const LogId& log) const {
    if (entries_.empty()) return nullptr;
    const std::uint32_t place = slots_[slot_of(log)];
    return place == 0 ? nullptr : &entries_[place - 1].second;
  }
  T& operator[](const LogId& log) {
    if (2 * (entries_.size() + 1) > slots_.size()) grow();
    std::uint32_t& place = slots_[slot_of(log)];
    if (place == 0) {
      entries_.emplace_back(std::piecewise_construct, std::forward_as_tuple(log), std::forward_as_tuple());
      place = static_cast<std::uint32_t>(entries_.size());
    }
    return entries_[place - 1].second;
  }
  void clear() {
    entries_.clear();
    std::fill(slots_.begin(), slots_.end(), 0u);
  }

 private:
  static std::uint64_t hash(const LogId& log) {
    const auto halves = std::bit_cast<std::array<std::uint64_t, 2>>(log.robot.bytes);
    std::uint64_t h = halves[0] * 0x9E3779B97F4A7C15u ^ std::rotl(halves[1] * 0xC2B2AE3D27D4EB4Fu, 31);
    h ^= (log.incarnation * 8 + log.lane) * 0x165667B19E3779F9u;
    h = (h ^ (h >> 32)) * 0xD6E8FEB86659FD93u;
    return h ^ (h >> 32);
  }
  // Where the log is, or its place would be. Some slots are always free.
  std::size_t slot_of(const LogId& log) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = hash(log) & mask;
    while (slots_[slot] != 0 && entries_[slots_[slot] - 1].first != log) slot = (slot + 1) & mask;
    return slot;
  }
  void grow() {
    slots_.assign(std::max<std::size_t>(16, 2 * slots_.size()), 0u);
    for (std::size_t i = 0; i < entries_.size(); ++i)
      slots_[slot_of(entries_[i].first)] = static_cast<std::uint32_t>(i + 1);
  }
  std::pmr::vector<Entry> entries_;
  std::pmr::vector<std::uint32_t> slots_;  // 1 + a place in entries_; 0: none
};

}  // namespace onemap::comms
