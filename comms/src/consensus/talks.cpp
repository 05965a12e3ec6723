#include "consensus/talks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "comms/consensus/linear_iteration.hpp"

namespace onemap::comms {

namespace {
using std::chrono::milliseconds;
constexpr auto kExchangeEvery = milliseconds(500);
constexpr auto kRoundLasts = std::chrono::seconds(5);  // at least, before this robot begins another
constexpr auto kRoundStays = milliseconds(400);        // before others' next one is joined
constexpr unsigned kQuietExchanges = 6;
constexpr unsigned kMarkBits = 24;
constexpr std::uint64_t kMark = (std::uint64_t{1} << kMarkBits) - 1;
constexpr std::uint64_t kFarAhead = std::uint64_t{1} << 20;  // rounds; nobody is so far behind

constexpr Duration kLatest = std::chrono::hours(24 * 365 * 100);  // half of the greatest clock that is believed

// Less than this is no change; and what a robot brings begins a round when it moved ten times as far.
constexpr std::array<double, kScalars> kTolerance{1e-4, 0.02, 1e-3};
constexpr double kWorthARound = 50;

std::size_t at(Scalar which) { return static_cast<std::size_t>(which); }

std::uint64_t mark_of(const RobotId& self, std::uint64_t incarnation) {
  std::uint64_t mark = incarnation;
  for (const auto byte : self.bytes) mark = mark * 0x100000001B3u + byte;
  return (mark ^ (mark >> 29)) & kMark;
}
}  // namespace

std::string_view name(Scalar which) {
  switch (which) {
    case Scalar::clock_offset:
      return "clock_offset_s";
    case Scalar::brightness:
      return "brightness";
    case Scalar::team_size:
      return "team_size";
    case Scalar::count:
      break;
  }
  return "none";
}

Talks::Talks(const RobotId& self, std::uint64_t incarnation, Memory& memory)
    : memory_(&memory),
      mark_(mark_of(self, incarnation)),
      sums_{RunningSums(Mass{}, memory), RunningSums(Mass{}, memory), RunningSums(Mass{}, memory)} {
  has_[at(Scalar::team_size)] = true;
}

void Talks::bring(Instant now, Scalar which, double own) {
  const std::size_t k = at(which);
  if (!std::isfinite(own) || std::abs(own) > RunningSums::kMost) return;
  const bool first = !has_[k];
  has_[k] = true;
  brought_[k] = own;
  if (round_ != 0 && (first || std::abs(own - in_use_[k]) > kWorthARound * kTolerance[k])) team_changed(now);
}

void Talks::team_changed(Instant now) {
  if (!begin_at_) begin_at_ = round_ == 0 ? now : std::max(now, begun_ + kRoundLasts);
}

Instant Talks::next() const { return begin_at_ ? std::min(*begin_at_, next_exchange_) : next_exchange_; }

// Who began brings its clock as 0, everybody else how far it is ahead of that.
Mass Talks::own_mass(std::size_t which) const {
  if (which == at(Scalar::team_size)) return {1.0, began_here_ ? 1.0 : 0.0};
  if (!has_[which]) return {};
  const double own = which == at(Scalar::clock_offset) ? brought_[which] - to_seconds(reference_) : brought_[which];
  return {own, 1.0};
}

void Talks::begin(Instant now, std::uint64_t round, Duration reference) {
  round_ = round;
  reference_ = reference;
  begun_ = now;
  in_use_ = brought_;
  for (std::size_t k = 0; k < kScalars; ++k) sums_[k].begin(own_mass(k));
  quiet_ = 0, exchanges_ = 0;
  next_exchange_ = now;
  begin_at_.reset();
}

bool Talks::exchange(Instant now, std::span<const Near> near) {
  if (begin_at_ && *begin_at_ <= now) {
    began_here_ = true;
    const double clock = brought_[at(Scalar::clock_offset)];
    begin(now, (((round_ >> kMarkBits) + 1) << kMarkBits) | mark_,
          Duration(static_cast<std::int64_t>(std::clamp(clock, -3e9, 3e9) * 1e9)));
  }
  if (next_exchange_ > now) return false;
  std::pmr::vector<RunningSums::Link> links(memory_);
  for (const Near& other : near) links.push_back({other.robot, metropolis_weight(near.size(), other.neighbours)});
  for (RunningSums& sums : sums_) sums.round(links);
  ++exchanges_;
  quiet_ = changed_since() ? 0 : quiet_ + 1;
  next_exchange_ = quiet_ < kQuietExchanges && !near.empty() ? now + kExchangeEvery : Instant::max();
  return true;
}

double Talks::value(std::size_t which) const { return sums_[which].value(std::numeric_limits<double>::quiet_NaN()); }

bool Talks::changed_since() {
  bool changed = false;
  for (std::size_t k = 0; k < kScalars; ++k) {
    const double now = value(k), before = std::exchange(last_[k], now);
    if (std::isnan(now) != std::isnan(before) || std::abs(now - before) > kTolerance[k] / 10) changed = true;
  }
  return changed;
}

void Talks::tell(Instant now, const RobotId& to, wire::Mass& mass) const {
  mass.round = round_;
  mass.clock_ns = (now.time_since_epoch() + reference_).count();
  for (std::size_t k = 0; k < kScalars; ++k) mass.given[k] = sums_[k].given_to(to);
}

bool Talks::heard(Instant now, const RobotId& from, const wire::Mass& mass, Duration on_its_way) {
  if (mass.round == 0) return true;
  const std::uint64_t count = mass.round >> kMarkBits, own = round_ >> kMarkBits;
  if ((round_ != 0 && count > own + kFarAhead) || std::abs(mass.clock_ns / 2) > kLatest.count()) return false;
  if (mass.round > round_) {
    if (round_ != 0 && now - begun_ < kRoundStays) return true;  // it will be said again
    began_here_ = false;
    begin(now, mass.round, Duration(mass.clock_ns) + on_its_way - now.time_since_epoch());
  }
  if (mass.round < round_ || !mass.has_amounts) return true;  // it will hear of ours; and it has nothing new
  for (std::size_t k = 0; k < kScalars; ++k) {
    const double before = value(k);
    if (!sums_[k].heard(from, mass.given[k])) return false;
    const double after = value(k);
    if (std::isnan(before) != std::isnan(after) || std::abs(after - before) > kTolerance[k]) quiet_ = 0;
  }
  if (quiet_ == 0) next_exchange_ = std::min(next_exchange_, now + kExchangeEvery);
  return true;
}

ScalarsView Talks::view() const {
  ScalarsView view;
  view.round_of_talks = round_;
  view.exchanges = exchanges_;
  view.settled = round_ != 0 && quiet_ >= kQuietExchanges;
  for (std::size_t k = 0; k < kScalars; ++k) {
    const double agreed = value(k);
    view.values[k] = {k == at(Scalar::team_size) ? 1.0 : brought_[k], agreed, round_ != 0 && !std::isnan(agreed)};
  }
  // Everybody's clocks in one frame: the team's mean is 0.
  ScalarValue& clock = view.values[at(Scalar::clock_offset)];
  if (clock.known) clock.own = own_mass(at(Scalar::clock_offset)).y - clock.agreed;
  if (!clock.known) clock.own = 0;
  clock.agreed = 0;
  return view;
}

}  // namespace onemap::comms
