#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hal/base/result.hpp"
#include "mapping/team/record_ptr.hpp"

namespace onemap::mapping {

// A record of voxels, and what its header says.
struct SubmapPlace {
  RecordPtr record;            // perhaps its head alone; nullptr: it is malformed, without blocks, or its body is gone
  std::uint32_t sequence = 0;  // in its log
  std::uint32_t anchor = 0;    // the keyframe in whose frame they lie
  std::uint32_t blocks = 0;
};

// The voxel records of one life of a robot, in the order of their log, each with its place, whatever it is worth: its
// first so many are the same in every robot. A record that a later one replaces (Seal::replaces) is no part of a map of
// so many records that the later one is among them, whoever still has it: so it may be let go once no map of fewer is
// made any more, and who comes later gets its head alone.
class SubmapLog {
 public:
  SubmapLog() = default;
  // heads_alone: bodies can be read again elsewhere, so they are not held here.
  explicit SubmapLog(bool heads_alone) : heads_alone_(heads_alone) {}

  // The next record. The error says what is malformed; it has its place all the same.
  Status add(const RecordPtr& record);

  std::size_t size() const { return all_.size(); }
  const SubmapPlace& operator[](std::size_t i) const { return all_[i].place; }
  // It is part of a map of the first `extent`.
  bool counts(std::size_t i, std::size_t extent) const {
    return i < extent && all_[i].place.record != nullptr && all_[i].replaced_at > extent;
  }
  // That map can be made here: what it needs has its body. False for those that let_go() was told of.
  bool is_whole(std::size_t extent) const;
  std::size_t most_whole() const;  // the greatest extent up to size() that is whole

  // Maps of fewer than this many are not made any more: what they alone needed is given up here. Which records that is.
  std::vector<RecordId> let_go(std::size_t extent);
  std::size_t replaced() const { return replaced_; }  // records that later ones replace, so far

 private:
  static constexpr std::uint32_t kNever = 0xFFFFFFFFu;
  struct Entry {
    SubmapPlace place;
    std::uint32_t replaced_at = kNever;  // maps of so many records and more do without it
  };
  void replace(const Record& by);

  bool heads_alone_ = false;
  std::vector<Entry> all_;
  std::vector<std::uint32_t> waiting_;  // of these, replaced ones that have their bodies
  std::vector<std::uint32_t> gone_;     // those that came without them, as long as a map may need them
  std::size_t least_ = 0;               // smaller maps than this lack a body
  std::size_t replaced_ = 0;
};

}  // namespace onemap::mapping
