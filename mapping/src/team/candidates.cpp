#include "mapping/team/candidates.hpp"

#include <algorithm>
#include <map>

#include "mapping/local/match.hpp"

namespace onemap::mapping {

namespace {

constexpr std::size_t kQuickFeatures = 128;  // for matching all pairs
constexpr float kQuickRatio = 0.8f;          // R@20 on the desk: 0.956, and 0.943 at 0.9
constexpr std::size_t kPlaces = 10;          // of the index for each keyframe
constexpr std::uint32_t kFewest = 8;         // features that are alike in a pair that is worth a look
constexpr std::size_t kMaxPairs = 32;        // looked at closely for a pair of robots
constexpr int kMaxOfCloud = 4;

// The first of a record's features are its strongest.
FeatureSet strongest(const KeyframeRecord& record) {
  FeatureSet some;
  some.kind = record.descriptor_kind;
  const std::size_t n = std::min(record.features.size(), kQuickFeatures);
  some.reserve(n);
  for (const KeyframeFeature& feature : std::span(record.features).first(n)) {
    Keypoint k;
    k.laplacian = feature.laplacian;
    some.keypoints.push_back(k);
    some.descriptors.push_back(from_bits(feature.bits));
  }
  return some;
}

std::vector<FeatureSet> strongest(const KeyframeSource& source) {
  std::vector<FeatureSet> out;
  out.reserve(source.count);
  for (std::size_t i = 0; i < source.count; ++i) out.push_back(strongest(source.load(i)));
  return out;
}

}  // namespace

std::vector<BinaryFeature> binary_features(const KeyframeRecord& record) {
  std::vector<BinaryFeature> out;
  out.reserve(record.features.size());
  for (const KeyframeFeature& feature : record.features) out.push_back({feature.bits, feature.laplacian});
  return out;
}

std::optional<std::vector<CloudPair>> ask_index(PlaceIndex& index, const KeyframeSource& asking,
                                                const std::function<bool()>& stop) {
  std::vector<CloudPair> all;
  for (std::size_t s = 0; s < asking.count; ++s) {
    if (stop()) return std::nullopt;
    const KeyframeRecord record = asking.load(s);
    for (const Place& place : index.query(record.descriptor_kind, binary_features(record), kPlaces))
      if (place.features >= kFewest) all.push_back({place.id.keyframe, s, place.votes});
  }
  return all;
}

std::optional<std::vector<CloudPair>> match_all_pairs(const KeyframeSource& a, const KeyframeSource& b,
                                                      const std::function<bool()>& stop) {
  const std::vector<FeatureSet> quick_a = strongest(a), quick_b = strongest(b);
  MatchConfig config;
  config.max_ratio = kQuickRatio;
  Matcher matcher(config, kQuickFeatures);
  std::vector<CloudPair> all;
  for (std::size_t r = 0; r < a.count; ++r) {
    if (stop()) return std::nullopt;
    for (std::size_t s = 0; s < b.count; ++s) {
      if (quick_a[r].kind != quick_b[s].kind) continue;
      const std::size_t n = matcher.match(quick_a[r], quick_b[s]).size();
      if (n >= kFewest) all.push_back({r, s, n});
    }
  }
  return all;
}

std::vector<CloudPair> choose(std::vector<CloudPair> all) {
  std::ranges::sort(all, [](const CloudPair& x, const CloudPair& y) {
    return x.votes != y.votes ? x.votes > y.votes : std::pair(x.r, x.s) < std::pair(y.r, y.s);
  });
  std::map<std::size_t, int> times_r, times_s;
  std::vector<CloudPair> chosen;
  for (const CloudPair& pair : all) {
    if (chosen.size() == kMaxPairs) break;
    if (times_r[pair.r] == kMaxOfCloud || times_s[pair.s] == kMaxOfCloud) continue;
    ++times_r[pair.r];
    ++times_s[pair.s];
    chosen.push_back(pair);
  }
  return chosen;
}

}  // namespace onemap::mapping
