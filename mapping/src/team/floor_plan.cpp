#include "mapping/team/floor_plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace onemap::mapping {
namespace {

constexpr double kFloor_m = 0.10;                  // to either side of the floor's height: what is hit there is floor
constexpr std::int64_t kMostSquares = 64'000'000;  // of a plan: 400 m x 400 m at 5 cm
constexpr double kLeastEmpty = 0.8;  // of a column, to be free where its floor was not seen: no table hides there

// The layers of cells whose middles lie in a range of heights.
struct Layers {
  std::int32_t first = 0, last = -1;
  Layers(double low_m, double high_m, double cell_m)
      : first(static_cast<std::int32_t>(std::ceil(low_m / cell_m - 0.5))),
        last(static_cast<std::int32_t>(std::floor(high_m / cell_m - 0.5))) {}
  bool hold(std::int32_t z) const { return first <= z && z <= last; }
  bool reach(const BlockKey& block) const {
    return block.z * kBlockSide <= last && block.z * kBlockSide + kBlockSide > first;
  }
};

// The squares from (x0, y0) to (x1, y1), both included.
struct Bounds {
  std::int32_t x0 = std::numeric_limits<std::int32_t>::max(), y0 = x0;
  std::int32_t x1 = std::numeric_limits<std::int32_t>::min(), y1 = x1;
  void include(std::int32_t x, std::int32_t y) {
    x0 = std::min(x0, x), x1 = std::max(x1, x);
    y0 = std::min(y0, y), y1 = std::max(y1, y);
  }
  bool empty() const { return x0 > x1; }
  std::int64_t width() const { return std::int64_t{x1} - x0 + 1; }
  std::int64_t height() const { return std::int64_t{y1} - y0 + 1; }
};

// The edge of a table seen along its top: few rays hit it, many pass just over it. What was there for a moment is
// forgotten later than by judged().
bool is_doubtful(CellVotes votes) { return votes.hit >= 2 && votes.seen_through <= 16 * votes.hit; }

// What is known of the column over one square.
struct Column {
  std::uint16_t occupied = 0, empty = 0;
  bool floor = false;
  bool doubtful = false;  // a cell was hit, too, though mostly seen through
};

// All columns over the blocks that matter.
class Columns {
 public:
  Columns(const FreeSpace& space, const FloorPlanConfig& config)
      : band_(config.low_m, config.high_m, space.config().cell_m),
        floor_(-kFloor_m, std::min(kFloor_m, config.low_m), space.config().cell_m) {
    space.for_each_sorted([&](const BlockKey& key, FreeSpace::BlockVotes) {
      if (!matters(key)) return;
      bounds_.include(key.x * kBlockSide, key.y * kBlockSide);
      bounds_.include(key.x * kBlockSide + kBlockSide - 1, key.y * kBlockSide + kBlockSide - 1);
    });
    if (bounds_.empty() || too_large()) return;
    columns_.resize(static_cast<std::size_t>(bounds_.width() * bounds_.height()));
    space.for_each_sorted([&](const BlockKey& key, FreeSpace::BlockVotes votes) {
      if (matters(key)) add(key, votes);
    });
  }

  const Bounds& bounds() const { return bounds_; }
  bool too_large() const { return !bounds_.empty() && bounds_.width() > kMostSquares / bounds_.height(); }

  Space judge(std::int32_t x, std::int32_t y) const {
    const Column& column = columns_[index(x, y)];
    if (column.occupied > 0) return Space::occupied;
    if (column.doubtful) return Space::unknown;
    const bool seen = column.empty >= kLeastEmpty * (band_.last - band_.first + 1);
    return seen || (column.floor && column.empty > 0) ? Space::empty : Space::unknown;
  }

 private:
  bool matters(const BlockKey& block) const { return band_.reach(block) || floor_.reach(block); }
  std::size_t index(std::int32_t x, std::int32_t y) const {
    return static_cast<std::size_t>((std::int64_t{y} - bounds_.y0) * bounds_.width() + (std::int64_t{x} - bounds_.x0));
  }
  void add(const BlockKey& key, FreeSpace::BlockVotes votes) {
    for (std::int32_t i = 0; i < kBlockVoxels; ++i) {
      const std::int32_t z = key.z * kBlockSide + i / (kBlockSide * kBlockSide);
      if (!band_.hold(z) && !floor_.hold(z)) continue;
      const Space space = judged(votes[static_cast<std::size_t>(i)]);
      Column& column =
          columns_[index(key.x * kBlockSide + i % kBlockSide, key.y * kBlockSide + i / kBlockSide % kBlockSide)];
      if (floor_.hold(z)) column.floor |= space == Space::occupied;
      if (!band_.hold(z)) continue;
      column.doubtful |= space == Space::empty && is_doubtful(votes[static_cast<std::size_t>(i)]);
      column.occupied = static_cast<std::uint16_t>(column.occupied + (space == Space::occupied ? 1 : 0));
      column.empty = static_cast<std::uint16_t>(column.empty + (space == Space::empty ? 1 : 0));
    }
  }

  const Layers band_, floor_;
  Bounds bounds_;
  std::vector<Column> columns_;
};

// The squares of which something is known.
Bounds known(const Columns& columns) {
  Bounds out;
  const Bounds& all = columns.bounds();
  for (std::int32_t y = all.y0; y <= all.y1; ++y)
    for (std::int32_t x = all.x0; x <= all.x1; ++x)
      if (columns.judge(x, y) != Space::unknown) out.include(x, y);
  return out;
}

}  // namespace

Result<FloorPlan> floor_plan(const FreeSpace& space, const FloorPlanConfig& config) {
  const Columns columns(space, config);
  if (columns.too_large()) return Error{"floor plan", "the map is larger than a plan may be (64 million squares)"};
  const Bounds bounds = columns.bounds().empty() ? Bounds{} : known(columns);
  if (bounds.empty()) return Error{"floor plan", "nothing is known of the space above the floor"};
  FloorPlan plan;
  plan.cell_m = space.config().cell_m;
  plan.width = static_cast<int>(bounds.width());
  plan.height = static_cast<int>(bounds.height());
  plan.origin_x_m = bounds.x0 * plan.cell_m;
  plan.origin_y_m = bounds.y0 * plan.cell_m;
  plan.cells.reserve(static_cast<std::size_t>(bounds.width() * bounds.height()));
  for (std::int32_t y = bounds.y0; y <= bounds.y1; ++y)
    for (std::int32_t x = bounds.x0; x <= bounds.x1; ++x) plan.cells.push_back(columns.judge(x, y));
  return plan;
}

}  // namespace onemap::mapping
