#include "mapping/team/place_index.hpp"

#include <algorithm>

#include "hal/base/splitmix.hpp"
#include "local/match_internal.hpp"
#include "team/place_search.hpp"

namespace onemap::mapping {

namespace {

constexpr std::size_t kShortCode = 16, kLongCode = 20;  // bits of a feature that choose its bucket
constexpr std::size_t kFeaturesAKeyframe = 64;          // at least, on average: what keyframes may be held
constexpr std::size_t kBytesAKeyframe = 256;            // with its place in the map and its tally
constexpr std::size_t kBytesABucket = 5;

std::size_t table_bytes(std::size_t bits) { return PlaceIndex::kTables * kBytesABucket << bits; }

std::uint64_t hash_of(const PlaceId& id) {
  std::uint64_t hash = SplitMix(id.incarnation).next() ^ id.keyframe;
  for (std::size_t i = 0; i < id.robot.bytes.size(); ++i) hash = SplitMix(hash + id.robot.bytes[i]).next();
  return hash;
}

}  // namespace

// Long codes have fewer features in a bucket that are not alike. Their tables are large: only for large indices.
PlaceIndex::PlaceIndex(const PlaceIndexConfig& config)
    : config_(config), table_bits_(3 * table_bytes(kLongCode) <= config.budget_bytes ? kLongCode : kShortCode) {
  const std::size_t tables = table_bytes(table_bits_);
  const std::size_t room = config.budget_bytes > tables ? config.budget_bytes - tables : 0;
  const std::size_t features = room / (sizeof(Entry) + sizeof(Owner) + kBytesAKeyframe / kFeaturesAKeyframe);
  heads_.resize(kTables << table_bits_);
  counts_.resize(kTables << table_bits_);
  entries_.resize(features);
  owners_.resize(features);
  max_keyframes_ = features / kFeaturesAKeyframe;
}

void PlaceIndex::clear() {
  std::fill(heads_.begin(), heads_.end(), 0u);
  std::fill(counts_.begin(), counts_.end(), std::uint8_t{0});
  free_ = untouched_ = 0;
  used_ = 0;
  keyframes_.clear();
  free_keyframes_.clear();
  slots_.clear();
  tallies_.clear();
}

// Table t looks at the bits from t * table_bits_ on.
std::size_t PlaceIndex::bucket(std::size_t table, const DescriptorBits& bits) const {
  const std::size_t first = table * table_bits_, word = first / 64, shift = first % 64;
  std::uint64_t code = bits[word] >> shift;
  if (shift + table_bits_ > 64) code |= bits[word + 1] << (64 - shift);
  return (table << table_bits_) + static_cast<std::size_t>(code & ((std::uint64_t{1} << table_bits_) - 1));
}

std::uint32_t PlaceIndex::take_entry() {
  ++used_;
  if (free_ == 0) return untouched_++;
  const std::uint32_t entry = free_ - 1;
  free_ = owners_[entry].sibling;
  return entry;
}

bool PlaceIndex::has_room(std::size_t features) const {
  return used_ + features <= entries_.size() && slots_.size() < max_keyframes_;
}

bool PlaceIndex::insert(const PlaceId& id, DescriptorKind kind, std::span<const BinaryFeature> features) {
  if (!has_room(features.size()) || features.size() > UINT16_MAX || slots_.contains(id)) return ++refused_, false;
  std::uint32_t slot = static_cast<std::uint32_t>(keyframes_.size());
  if (!free_keyframes_.empty()) {
    slot = free_keyframes_.back();
    free_keyframes_.pop_back();
  } else {
    keyframes_.emplace_back();
    tallies_.emplace_back();
  }
  slots_[id] = slot;
  Keyframe& keyframe = keyframes_[slot] = {id, kind, 0, hash_of(id)};
  for (std::size_t i = 0; i < features.size(); ++i) {
    const std::uint32_t entry = take_entry();
    entries_[entry] = {features[i].bits, {}};
    owners_[entry] = {slot, keyframe.features, static_cast<std::uint16_t>(i),
                      static_cast<std::int8_t>(features[i].laplacian)};
    keyframe.features = entry + 1;
    for (std::size_t t = 0; t < kTables; ++t) link(t, entry);
  }
  return true;
}

std::uint64_t PlaceIndex::precedence(std::uint32_t entry) const {
  return SplitMix(keyframes_[owners_[entry].keyframe].hash + owners_[entry].ordinal).next();
}

void PlaceIndex::link(std::size_t table, std::uint32_t entry) {
  const std::size_t at = bucket(table, entries_[entry].bits);
  if (counts_[at] == kMaxBucket) {
    ++crowded_out_;
    std::uint32_t last = heads_[at] - 1;
    for (std::uint32_t other = heads_[at]; other != 0; other = entries_[other - 1].next[table])
      if (precedence(other - 1) > precedence(last)) last = other - 1;
    if (precedence(entry) >= precedence(last)) return;
    unlink(table, last);
  }
  entries_[entry].next[table] = heads_[at];
  heads_[at] = entry + 1;
  ++counts_[at];
}

// Nothing happens when it was crowded out.
void PlaceIndex::unlink(std::size_t table, std::uint32_t entry) {
  const std::size_t at = bucket(table, entries_[entry].bits);
  for (std::uint32_t* link = &heads_[at]; *link != 0; link = &entries_[*link - 1].next[table]) {
    if (*link != entry + 1) continue;
    *link = entries_[entry].next[table];
    --counts_[at];
    return;
  }
}

bool PlaceIndex::remove(const PlaceId& id) {
  const auto found = slots_.find(id);
  if (found == slots_.end()) return false;
  const std::uint32_t slot = found->second;
  for (std::uint32_t at = keyframes_[slot].features; at != 0;) {
    const std::uint32_t entry = at - 1;
    for (std::size_t t = 0; t < kTables; ++t) unlink(t, entry);
    at = owners_[entry].sibling;
    owners_[entry].sibling = free_;
    free_ = entry + 1;
    --used_;
  }
  free_keyframes_.push_back(slot);
  slots_.erase(found);
  return true;
}

// Begins the tallies; how many keyframes take part.
std::size_t PlaceIndex::ask(DescriptorKind kind, const Filter& filter) {
  std::fill(tallies_.begin(), tallies_.end(), Tally{});
  std::size_t asked = 0;
  for (const auto& [id, slot] : slots_) {
    tallies_[slot].asked = keyframes_[slot].kind == kind && filter(id);
    asked += tallies_[slot].asked ? 1 : 0;
  }
  return asked;
}

// One vote a keyframe, by its feature that is most alike: log((asked + 1) / (n + 1/2)) x closeness, where n keyframes
// have one.
void PlaceIndex::vote(const BinaryFeature& feature, std::uint32_t log_of_all) {
  place::Search search;
  search.entries = entries_.data();
  search.bits = feature.bits;
  search.max_distance = config_.max_distance;
  for (std::size_t t = 0; t < kTables; ++t) search.heads[t] = heads_[bucket(t, feature.bits)];
  (config_.simd && match::simd_available() ? place::search_simd : place::search_plain)(search);
  near_.clear();
  for (const place::Near& near : std::span(search.near).first(search.found)) {
    const Owner& owner = owners_[near.entry];
    Tally& tally = tallies_[owner.keyframe];
    if (!tally.asked || owner.laplacian != feature.laplacian) continue;
    if (tally.nearest == Tally{}.nearest) near_.push_back(owner.keyframe);
    tally.nearest = std::min(tally.nearest, static_cast<std::uint8_t>(near.distance));
  }
  const std::uint32_t rarity = log_of_all - place::log2_fixed(2 * near_.size() + 1);
  for (const std::uint32_t slot : near_) {
    Tally& tally = tallies_[slot];
    tally.votes += std::uint64_t{rarity} * static_cast<std::uint64_t>(config_.max_distance + 1 - tally.nearest);
    ++tally.features;
    tally.nearest = Tally{}.nearest;
  }
}

std::vector<Place> PlaceIndex::ranked(std::size_t k) const {
  std::vector<Place> out;
  for (const auto& [id, slot] : slots_)
    if (tallies_[slot].votes > 0) out.push_back({id, tallies_[slot].votes, tallies_[slot].features});
  const std::size_t n = std::min(k, out.size());
  const auto before = [](const Place& x, const Place& y) {
    return x.votes != y.votes ? x.votes > y.votes : x.id < y.id;
  };
  std::partial_sort(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(n), out.end(), before);
  out.resize(n);
  return out;
}

std::vector<Place> PlaceIndex::query(DescriptorKind kind, std::span<const BinaryFeature> features, std::size_t k,
                                     const Filter& filter) {
  const std::uint32_t log_of_all = place::log2_fixed(2 * ask(kind, filter) + 2);
  for (const BinaryFeature& feature : features) vote(feature, log_of_all);
  return ranked(k);
}

std::size_t PlaceIndex::bytes() const {
  return heads_.size() * (sizeof(std::uint32_t) + sizeof(std::uint8_t)) +
         entries_.size() * (sizeof(Entry) + sizeof(Owner)) + max_keyframes_ * kBytesAKeyframe;
}

}  // namespace onemap::mapping
