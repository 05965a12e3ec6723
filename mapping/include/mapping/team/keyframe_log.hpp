#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hal/base/result.hpp"
#include "hal/base/time.hpp"
#include "mapping/geometry.hpp"
#include "mapping/team/record_ptr.hpp"

namespace onemap::mapping {

// Where a keyframe is, and the keyframe whose submap its surface is in.
struct KeyframePlace {
  std::uint32_t index = 0, anchor = 0;       // the robot's own count
  std::uint32_t position = 0, sequence = 0;  // of its record: among the keyframes, and in the log
  bool gone = false;                         // what it saw is read no more
  QuantizedPose T_robot_keyframe;
  FrameTime time{};
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

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  // nullptr: nothing that it saw can be read here.
  const RecordPtr& operator[](std::size_t i) const;
  // By position. There is none where the record is malformed, only repeats the place of another, or has no body and
  // what remains of it did not come yet.
  const std::vector<KeyframePlace>& places() const { return places_; }
  const KeyframePlace* place(std::size_t position) const;  // nullptr: there is none
  std::vector<KeyframePlace> chain() const;                // by their indices; of those that claim one the first

  // What is missing among the first `extent` will not be missed: no place waits for what remains.
  bool is_whole(std::size_t extent) const;
  std::size_t most_whole() const;  // the greatest extent up to size() that is whole

  // Positions whose views went, in the order in which they did; it only grows.
  const std::vector<std::uint32_t>& gone() const { return gone_; }
  // Bodies that were here and that nobody reads again: once each.
  std::vector<RecordId> let_go();

 private:
  struct View {
    std::uint32_t position = 0;
    RecordPtr record;
  };
  struct Gap {  // a position without a place
    std::uint32_t position = 0, sequence = 0;
  };
  bool replace(std::uint32_t sequence, const KeyframePlace& by);  // false: there is no such one

  std::size_t size_ = 0;
  std::vector<View> views_;  // that are there, by position
  std::vector<KeyframePlace> places_;
  std::vector<Gap> gaps_;            // heads alone, whose places did not come yet
  std::vector<Gap> placeless_;       // malformed, or only repeating another's place: who has a head alone cannot tell
  std::vector<std::uint32_t> gone_;  // positions
  std::vector<RecordId> unread_;
};

}  // namespace onemap::mapping
