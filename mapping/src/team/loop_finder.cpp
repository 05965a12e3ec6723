#include "mapping/team/loop_finder.hpp"

#include <algorithm>
#include <map>
#include <numeric>

#include "team/verify_clouds.hpp"

namespace onemap::mapping {

namespace {

constexpr std::uint32_t kNeighbours = 20;     // keyframes that odometry, or the tracker's landmarks, join anyway
constexpr std::size_t kPlaces = 6;            // of the index for each keyframe
constexpr std::uint32_t kFewest = 12;         // features that are alike in a pair that is worth a look
constexpr std::size_t kLooks = 2;             // closely, for each keyframe
constexpr int kTriesOfAnchors = 8;            // closely, for each pair of anchors
constexpr std::ptrdiff_t kKeptOfAnchors = 3;  // more of one view say nothing new
constexpr double kRecent = 16;                // of a way; of this share of it the newest part keeps more loops

std::pair<std::uint32_t, std::uint32_t> ends(const LinkPair& pair) { return {pair.keyframe_a, pair.keyframe_b}; }

}  // namespace

std::size_t least_missed(std::span<const LinkPair> pairs) {
  std::vector<std::size_t> along(pairs.size());
  std::iota(along.begin(), along.end(), std::size_t{0});
  std::ranges::stable_sort(along, {}, [&](std::size_t i) { return pairs[i].keyframe_b; });
  const auto at = [&](std::size_t k) { return static_cast<double>(pairs[along[k]].keyframe_b); };
  const double newest = at(along.size() - 1), old = std::max(newest / kRecent, double{kNeighbours});
  const auto missed = [&](std::size_t k) {
    const double before = k == 0 ? 0 : at(k - 1), after = k + 1 == along.size() ? newest : at(k + 1);
    return std::pair{(after - before) / std::min(newest - at(k) + kNeighbours, old), pairs[along[k]].inliers};
  };
  std::size_t least = 0;
  for (std::size_t k = 1; k < along.size(); ++k)
    if (missed(k) < missed(least)) least = k;
  return along[least];
}

void LoopFinder::begin_life(const TeamMember& own) {
  if (life_ == own.incarnation && looked_ <= own.keyframes.size()) return;
  life_ = own.incarnation;
  looked_ = told_ = 0;
  found_.clear();
  tried_.clear();
  untold_ = false;
}

// Positions in the log, the likeliest first. Only earlier keyframes are asked, so it does not matter how many the index
// holds by now.
std::vector<std::uint32_t> LoopFinder::candidates(const TeamMember& own, const KeyframeRecord& keyframe,
                                                  PlaceIndex& index) const {
  const auto may = [&](const PlaceId& id) {
    const KeyframePlace* place = id.keyframe < looked_ ? own.keyframes.place(id.keyframe) : nullptr;
    return place != nullptr && !place->gone && place->index + kNeighbours <= keyframe.index &&
           place->anchor != keyframe.anchor;
  };
  std::vector<std::uint32_t> out;
  for (const Place& place : index.query(keyframe.descriptor_kind, binary_features(keyframe), kPlaces, may))
    if (place.features >= kFewest) out.push_back(place.id.keyframe);
  return out;
}

void LoopFinder::keep(const LinkPair& pair, std::uint32_t anchor_a, std::uint32_t anchor_b) {
  const auto same = [&](const Found& f) { return f.anchor_a == anchor_a && f.anchor_b == anchor_b; };
  const auto weaker = [](const Found& x, const Found& y) { return x.pair.inliers < y.pair.inliers; };
  if (std::ranges::count_if(found_, same) < kKeptOfAnchors) {
    found_.push_back({pair, anchor_a, anchor_b});
    untold_ = true;
    if (found_.size() > kMaxLinkPairs) forget_one();
    return;
  }
  auto weakest = found_.end();
  for (auto at = found_.begin(); at != found_.end(); ++at)
    if (same(*at) && (weakest == found_.end() || weaker(*at, *weakest))) weakest = at;
  if (pair.inliers <= weakest->pair.inliers) return;
  *weakest = {pair, anchor_a, anchor_b};
  untold_ = true;
}

void LoopFinder::forget_one() {
  std::vector<LinkPair> pairs;
  pairs.reserve(found_.size());
  for (const Found& found : found_) pairs.push_back(found.pair);
  found_.erase(found_.begin() + static_cast<std::ptrdiff_t>(least_missed(pairs)));
}

std::vector<LoopFinder::Tried>::iterator LoopFinder::tried(const std::pair<std::uint32_t, std::uint32_t>& anchors) {
  const auto at = std::ranges::lower_bound(tried_, anchors, {}, &Tried::anchors);
  return at != tried_.end() && at->anchors == anchors ? at : tried_.insert(at, Tried{anchors, 0});
}

bool LoopFinder::look(const Agreement& team, OwnPlaces& places, const std::function<bool()>& stop) {
  const RobotId& self = team.log().self();
  const TeamMember* own = team.log().own();
  if (own == nullptr) return false;
  begin_life(*own);
  if (looked_ == own->keyframes.size()) return false;
  const KeyframeSource source = keyframes_of(self, *own);
  const KeyframeRecord keyframe = source.load(looked_);
  const auto asked = candidates(*own, keyframe, places.up_to_date(self, *own));
  const Cloud cloud = asked.empty() ? Cloud{} : unpack(keyframe, Normals::none);
  std::vector<std::pair<LinkPair, std::uint32_t>> verified;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> tries;  // counted when the look was not stopped
  std::size_t looks = 0;
  for (const std::uint32_t position : asked) {
    if (stop()) return false;
    const KeyframeRecord earlier = source.load(position);
    const std::pair anchors{earlier.anchor, keyframe.anchor};
    int& now = tries[anchors];
    if (tried(anchors)->times + now >= kTriesOfAnchors) continue;
    ++now;
    const PairResult result = verify_clouds(unpack(earlier), cloud, config_).result;
    if (result.reason == LinkReason::accepted)
      verified.push_back(
          {{earlier.index, keyframe.index, static_cast<std::uint32_t>(result.inliers), quantize(result.T_r_s)},
           earlier.anchor});
    if (++looks == kLooks) break;
  }
  for (const auto& [anchors, count] : tries) tried(anchors)->times += count;
  for (const auto& [pair, anchor] : verified) keep(pair, anchor, keyframe.anchor);
  ++looked_;
  return true;
}

std::optional<LinkRecord> LoopFinder::news(const Agreement& team, Instant now) {
  const RobotId& self = team.log().self();
  const TeamMember* own = team.log().own();
  if (own == nullptr || own->incarnation != life_ || looked_ == 0) return std::nullopt;
  const bool end = looked_ == own->keyframes.size() && team.keyframes_here(team.log().own_chain());
  const bool now_and_then = untold_ && interval_ > Duration::zero() && now >= next_;
  if (!(end && told_ != looked_) && !now_and_then) return std::nullopt;
  untold_ = false;
  told_ = looked_;
  next_ = now + interval_;
  LinkRecord out;
  out.a = out.b = self;
  out.incarnation_other = life_;
  out.keyframes_a = out.keyframes_b = static_cast<std::uint32_t>(looked_);
  out.reason = found_.empty() ? LinkReason::too_few_matches : LinkReason::accepted;
  for (const Found& found : found_) {
    out.pairs.push_back(found.pair);
    out.inliers += found.pair.inliers;
  }
  std::ranges::sort(out.pairs, {}, ends);
  const auto same = [](const LinkPair& x, const LinkPair& y) { return ends(x) == ends(y); };
  out.pairs.erase(std::unique(out.pairs.begin(), out.pairs.end(), same), out.pairs.end());
  out.supporting_pairs = static_cast<std::uint32_t>(out.pairs.size());
  return out;
}

}  // namespace onemap::mapping
