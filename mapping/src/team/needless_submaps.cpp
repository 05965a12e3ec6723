#include "mapping/team/needless_submaps.hpp"

#include <algorithm>
#include <chrono>
#include <functional>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "floor_int.hpp"
#include "mapping/team/placed_anchors.hpp"

namespace onemap::mapping {

namespace {

constexpr std::chrono::seconds kLeftFor{60};  // between two visits
constexpr double kCellBlocks = 2;             // a cell's side, in blocks: grids of different submaps do not lie alike
constexpr std::uint64_t kMostLost = 50;       // of what a record saw, one of so many

std::uint64_t cell_of(const Vector3d& at, double side) {
  const auto bits = [&](double x) {
    return static_cast<std::uint64_t>(floor_int<std::int64_t>(std::clamp(x / side, -1e6, 1e6)) + (1 << 20));
  };
  return bits(at.x()) | bits(at.y()) << 21 | bits(at.z()) << 42;
}

}  // namespace

// How well the map's cells were seen.
class NeedlessSubmaps::Evidence {
 public:
  void add(const std::vector<Piece>& pieces, double block_m, const Visit& visit) {
    for (const Piece& piece : pieces) {
      const Vector3d middle(piece.key.x + 0.5, piece.key.y + 0.5, piece.key.z + 0.5);
      cells_[cell_of(*visit.T_map_anchor * (block_m * middle), kCellBlocks * block_m)] += piece.evidence;
    }
  }
  std::uint64_t sum() const {
    return std::accumulate(cells_.begin(), cells_.end(), std::uint64_t{0},
                           [](std::uint64_t sum, const auto& cell) { return sum + cell.second; });
  }
  std::uint64_t beyond(const Evidence& other) const {  // in each cell what the other has less
    std::uint64_t out = 0;
    for (const auto& [cell, amount] : cells_) {
      const auto there = other.cells_.find(cell);
      const std::uint64_t covered = there == other.cells_.end() ? 0 : there->second;
      out += amount - std::min(amount, covered);
    }
    return out;
  }

 private:
  std::map<std::uint64_t, std::uint64_t> cells_;
};

std::vector<std::uint32_t> NeedlessSubmaps::look(const TeamMember& own, const SolvedRobot& solved) {
  if (std::exchange(life_, own.incarnation) != own.incarnation) looked_ = 0, kept_.clear();
  for (; looked_ < own.submaps.size(); ++looked_)
    if (const SubmapPlace* place = own.submaps.find(looked_); place != nullptr) take(*place);
  std::vector<std::uint32_t> out = sent_again();
  const std::vector<std::uint32_t> again = seen_again(own, solved);
  out.insert(out.end(), again.begin(), again.end());
  std::ranges::sort(out);
  return out;
}

// What went out again is the later record's.
void NeedlessSubmaps::take(const SubmapPlace& place) {
  const RecordPtr read = place.record != nullptr ? whole(place.record, read_) : nullptr;
  if (read == nullptr) return;
  const auto record = decode_submap(read->body);
  if (!record || record->blocks.empty()) return;  // that only names another one costs nothing
  Kept fresh{place.sequence, record->anchor_keyframe, record->voxel_um * 1e-6 * kBlockSide, {}};
  fresh.pieces.reserve(record->blocks.size());
  for (const SubmapBlock& block : record->blocks)
    fresh.pieces.push_back(
        {block.key, std::accumulate(block.voxels.begin(), block.voxels.end(), 0u,
                                    [](std::uint32_t sum, const SubmapVoxel& v) { return sum + v.weight; })});
  for (Kept& older : kept_)
    if (older.anchor == fresh.anchor)
      std::erase_if(older.pieces, [&](const Piece& piece) {
        return std::ranges::binary_search(fresh.pieces, piece.key, {}, &Piece::key);
      });
  kept_.push_back(std::move(fresh));
}

std::vector<std::uint32_t> NeedlessSubmaps::sent_again() {
  std::vector<std::uint32_t> out;
  std::erase_if(kept_, [&](const Kept& kept) {
    if (kept.pieces.empty()) out.push_back(kept.sequence);
    return kept.pieces.empty();
  });
  return out;
}

NeedlessSubmaps::Visits NeedlessSubmaps::visits(const TeamMember& own, const SolvedRobot& solved) {
  Visits out;
  for (const KeyframePlace& place : own.keyframes.places()) {
    const auto [at, first] = out.try_emplace(place.anchor);
    Visit& visit = at->second;
    visit.begin = first ? place.time : std::min(visit.begin, place.time);
    visit.end = std::max(visit.end, place.time);
  }
  for (const PlacedAnchor& anchor : placed_anchors(own, solved, own.keyframes.size()))
    if (const auto at = out.find(anchor.keyframe); at != out.end())
      at->second.T_map_anchor = from_quantized(anchor.T_map_anchor);
  std::erase_if(out, [](const auto& visit) { return !visit.second.T_map_anchor; });
  return out;
}

std::vector<std::uint32_t> NeedlessSubmaps::seen_again(const TeamMember& own, const SolvedRobot& solved) {
  const Visits visits = NeedlessSubmaps::visits(own, solved);
  std::vector<Placed> by_end;  // the latest first
  for (const Kept& kept : kept_)
    if (const auto at = visits.find(kept.anchor); at != visits.end()) by_end.push_back({&kept, &at->second});
  std::vector<Placed> by_begin = by_end;
  std::ranges::stable_sort(by_end, std::greater<>(), [](const Placed& p) { return p.visit->end; });
  std::ranges::stable_sort(by_begin, std::greater<>(), [](const Placed& p) { return p.visit->begin; });

  std::set<std::uint32_t> needless;
  Evidence since;
  auto next = by_begin.begin();
  for (const Placed& then : by_end) {
    for (; next != by_begin.end() && next->visit->begin >= then.visit->end + kLeftFor; ++next)
      if (!needless.contains(next->kept->sequence)) since.add(next->kept->pieces, next->kept->block_m, *next->visit);
    Evidence saw;
    saw.add(then.kept->pieces, then.kept->block_m, *then.visit);
    if (kMostLost * saw.beyond(since) <= saw.sum()) needless.insert(then.kept->sequence);
  }
  std::erase_if(kept_, [&](const Kept& kept) { return needless.contains(kept.sequence); });
  return {needless.begin(), needless.end()};
}

}  // namespace onemap::mapping
