#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "hal/base/result.hpp"
#include "hal/base/time.hpp"
#include "mapping/geometry.hpp"
#include "mapping/team/record_ptr.hpp"

namespace onemap::mapping {

// Where a keyframe is, and the keyframe whose submap its surface is in.
struct KeyframePlace {
  static constexpr std::uint32_t kUnknown = std::numeric_limits<std::uint32_t>::max();

  std::uint32_t index = kUnknown, anchor = 0;  // the robot's own count
  QuantizedPose T_robot_keyframe;
  FrameTime time{};
  bool known() const { return index != kUnknown; }
};

// The keyframe records of one life of a robot, in the order of their log, each with its position, whatever it is worth.
// One without features and depth is a keyframe's place and nothing that it saw. When it names an earlier record
// (Seal::replaces), it is what remains of that one: the place stands at the earlier position, and the earlier body is
// read no more, so it may be let go, and who comes later gets its head alone and waits for what remains.
class KeyframeLog {
 public:
  static constexpr std::size_t kMost = 32768;  // beyond: refused

  // The next record. The error says what is malformed; it has its position all the same.
  Status add(const RecordPtr& record);

  std::size_t size() const { return places_.size(); }
  bool empty() const { return places_.empty(); }
  // nullptr: nothing that it saw can be read here.
  const RecordPtr& operator[](std::size_t i) const;
  // By position; unknown where the record is malformed, only repeats the place of another, or has no body and what
  // remains of it did not come yet.
  const std::vector<KeyframePlace>& places() const { return places_; }
  std::vector<KeyframePlace> chain() const;  // the known ones, by their indices; of those that claim one the first
  std::size_t replaced() const { return replaced_.size(); }  // by what remains of them

  // What is missing among the first `extent` will not be missed: no place waits for what remains.
  bool is_whole(std::size_t extent) const;
  std::size_t most_whole() const;  // the greatest extent up to size() that is whole

  // Positions whose views went, in the order in which they did; it only grows.
  const std::vector<std::uint32_t>& gone() const { return replaced_; }
  // Bodies that were here and that nobody reads again: once each.
  std::vector<RecordId> let_go();

 private:
  struct View {
    std::uint32_t position = 0;
    RecordPtr record;
  };
  void replace(std::size_t position, const KeyframePlace& place);
  std::size_t position_of(std::uint32_t sequence, std::size_t before) const;  // `before`: there is none

  std::vector<std::uint32_t> sequences_;  // in the log, of each position
  std::vector<View> views_;               // that are there, by position
  std::vector<KeyframePlace> places_;
  std::vector<std::uint32_t> gaps_;      // positions of heads alone, whose places did not come yet
  std::vector<std::uint32_t> replaced_;  // positions
  std::vector<RecordId> unread_;
};

}  // namespace onemap::mapping
