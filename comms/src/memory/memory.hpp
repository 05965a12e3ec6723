#pragma once
#include <array>
#include <cstddef>
#include <memory_resource>
#include <utility>
#include <vector>

#include "hal/base/record.hpp"

namespace onemap::comms {

// Where what lasts is kept: a Node's Arena, or the heap for a part by itself. It must outlive what is kept there.
using Memory = std::pmr::memory_resource;
inline Memory& heap() { return *std::pmr::new_delete_resource(); }

// A container for each lane.
template <class T>
std::array<T, kLaneCount> of_each_lane(Memory& memory) {
  return [&]<std::size_t... lane>(std::index_sequence<lane...>) {
    return std::array<T, kLaneCount>{((void)lane, T(&memory))...};
  }
  (std::make_index_sequence<kLaneCount>());
}

// Of a list that grows for as long as the team works: an eighth of it may be empty, not half.
template <class T>
void append_snugly(std::pmr::vector<T>& list, const T& value) {
  if (list.size() == list.capacity()) list.reserve(list.size() + list.size() / 8 + 16);
  list.push_back(value);
}

}  // namespace onemap::comms
