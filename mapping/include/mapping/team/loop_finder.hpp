#pragma once
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "mapping/team/agreement.hpp"
#include "mapping/team/own_places.hpp"
#include "mapping/team/verify.hpp"

namespace onemap::mapping {

// Of too many loops the one that is missed least: of pairs of keyframes, of which the later ends are the robot's way,
// that which leaves the smallest gap, so that the whole way is held evenly; in the newest sixteenth of it the smallest
// for how long ago it is, so that where the robot is now is held by more. Of those the weakest. There must be one.
std::size_t least_missed(std::span<const LinkPair> pairs);

// Finds where this robot came back to a place that it knows: each of its keyframes asks the place index once for
// earlier ones that are not its neighbours, and the likeliest are looked at closely. One keyframe at a time and in
// order, so what is found follows from the keyframes alone. Used by one thread.
class LoopFinder {
 public:
  // interval: at most so often what was found is told while the robot maps; zero: only at the end.
  LoopFinder(const VerifyConfig& config, Duration interval) : config_(config), interval_(interval) {}

  // Looks at the next keyframe; false when all that are here have been looked at, or stop() said true in between.
  bool look(const Agreement& team, OwnPlaces& places, const std::function<bool()>& stop);
  // What has to be written: what was found since the last time; at the end always, from all keyframes.
  std::optional<LinkRecord> news(const Agreement& team, Instant now);

 private:
  void begin_life(const TeamMember& own);
  std::vector<std::uint32_t> candidates(const TeamMember& own, const KeyframeRecord& keyframe, PlaceIndex& index) const;
  void keep(const LinkPair& pair, std::uint32_t anchor_a, std::uint32_t anchor_b);
  void forget_one();

  struct Found {
    LinkPair pair;
    std::uint32_t anchor_a = 0, anchor_b = 0;
  };
  struct Tried {  // of a pair of anchors
    std::pair<std::uint32_t, std::uint32_t> anchors;
    int times = 0;
  };
  std::vector<Tried>::iterator tried(const std::pair<std::uint32_t, std::uint32_t>& anchors);  // added when it is new
  const VerifyConfig config_;
  const Duration interval_;
  std::uint64_t life_ = 0;
  std::size_t looked_ = 0;    // keyframes of the log
  std::vector<Found> found_;  // at most kMaxLinkPairs
  std::vector<Tried> tried_;  // sorted by anchors
  bool untold_ = false;
  std::size_t told_ = 0;  // keyframes that were looked at when the last news was told
  Instant next_{};        // not told again before
};

}  // namespace onemap::mapping
