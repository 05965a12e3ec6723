#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "mapping/records/keyframe.hpp"
#include "mapping/team/place_index.hpp"

namespace onemap::mapping {

// One robot's keyframes, each decoded only while it is looked at: load(i) for i < count gives the same record every
// time.
struct KeyframeSource {
  RobotId robot;
  std::size_t count = 0;
  std::function<KeyframeRecord(std::size_t)> load;
};

// Keyframe r of robot a and s of robot b may show one place; the more votes, the likelier.
struct CloudPair {
  std::size_t r = 0, s = 0;
  std::uint64_t votes = 0;
  bool operator==(const CloudPair&) const = default;
};

// How the pairs of clouds that are worth a closer look are found.
enum class FindPairs : std::uint8_t {
  by_index,   // each keyframe of one robot asks the place index of the other's
  all_pairs,  // the paper's: the strongest features of every two keyframes are matched
};

// The features of a record as the place index takes them.
std::vector<BinaryFeature> binary_features(const KeyframeRecord& record);

// For each keyframe of `asking`, the places in the index, whose ids are of one robot and life, with their positions in
// its source as keyframes: r is the place, s who asks. Nothing when stopped.
std::optional<std::vector<CloudPair>> ask_index(PlaceIndex& index, const KeyframeSource& asking,
                                                const std::function<bool()>& stop);

// By matching all pairs of clouds; the votes are matches. Nothing when stopped.
std::optional<std::vector<CloudPair>> match_all_pairs(const KeyframeSource& a, const KeyframeSource& b,
                                                      const std::function<bool()>& stop);

// Of these the pairs that are looked at closely, the best first: spread over the clouds, none more than four times, and
// at most 32 in all.
std::vector<CloudPair> choose(std::vector<CloudPair> all);

}  // namespace onemap::mapping
