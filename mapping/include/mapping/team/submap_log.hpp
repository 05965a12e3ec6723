#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hal/base/result.hpp"
#include "mapping/team/record_ptr.hpp"

namespace onemap::mapping {

// A record of voxels, and what its header says.
struct SubmapPlace {
  RecordPtr record;                          // perhaps its head alone; nullptr: it came without its body
  std::uint32_t position = 0, sequence = 0;  // among the voxel records, and in the log
  std::uint32_t anchor = 0;                  // the keyframe in whose frame they lie
  std::uint32_t blocks = 0;
};

// The voxel records of one life of a robot, in the order of their log, each with its position, whatever it is worth:
// its first so many are the same in every robot. Only those are held that a map may have: not what is malformed or
// without blocks, nor what was let go. A record that a later one replaces (Seal::replaces) is no part of a map of so
// many records that the later one is among them, whoever still has it: so it may be let go once no map of fewer is made
// any more, and who comes later gets its head alone.
class SubmapLog {
 public:
  SubmapLog() = default;
  // heads_alone: bodies can be read again elsewhere, so they are not held here.
  explicit SubmapLog(bool heads_alone) : heads_alone_(heads_alone) {}

  // The next record. The error says what is malformed; it has its place all the same.
  Status add(const RecordPtr& record);

  std::size_t size() const { return size_; }
  const SubmapPlace* find(std::size_t position) const;  // nullptr: it is not held
  // What is part of a map of the first `extent`, by position: fn(SubmapPlace).
  template <class Fn>
  void for_each_of(std::size_t extent, Fn&& fn) const {
    for (const Entry& entry : held_)
      if (entry.place.position < extent && entry.place.record != nullptr && entry.replaced_at > extent) fn(entry.place);
  }
  // That map can be made here: what it needs has its body. False for those that let_go() was told of.
  bool is_whole(std::size_t extent) const;
  std::size_t most_whole() const;  // the greatest extent up to size() that is whole

  // Maps of fewer than this many are not made any more: what they alone needed is given up here. Which records that is.
  std::vector<RecordId> let_go(std::size_t extent);

 private:
  static constexpr std::uint32_t kNever = 0xFFFFFFFFu;
  struct Entry {
    SubmapPlace place;
    std::uint32_t replaced_at = kNever;  // maps of so many records and more do without it
  };
  void replace(std::uint32_t sequence);
  bool lacks(const Entry& entry, std::size_t extent) const {
    return entry.place.record == nullptr && entry.place.position < extent && entry.replaced_at > extent;
  }

  bool heads_alone_ = false;
  std::size_t size_ = 0;
  std::vector<Entry> held_;
  std::size_t least_ = 0;  // smaller maps than this lack a body
};

}  // namespace onemap::mapping
