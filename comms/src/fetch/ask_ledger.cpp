#include "fetch/ask_ledger.hpp"

#include <algorithm>

namespace onemap::comms {

namespace {
constexpr std::uint8_t kOvertakenBy = 3;
}  // namespace

void AskLedger::add(Instant now, const Fragment& fragment, std::uint32_t serial) {
  Lane& lane = lanes_[fragment.id.log.lane];
  if (lane.outstanding++ == 0) lane.progress = now;
  lane.asks.push_back({fragment, serial, false, 0, std::nullopt});
}

void AskLedger::answered(Instant now, std::uint8_t lane_index, std::uint32_t serial) {
  Lane& lane = lanes_[lane_index];
  for (Ask& ask : lane.asks) {
    if (ask.serial == serial) {
      finish(lane, ask);
      break;
    }
    if (ask.done || ask.overtaken == kOvertakenBy || ++ask.overtaken < kOvertakenBy) continue;
    ask.overtaken_at = now;
    if (!lane.suspect_since) lane.suspect_since = now;
  }
  trim(lane);
}

void AskLedger::progressed(Instant now, std::uint8_t lane) {
  for (std::size_t i = lane; i < lanes_.size(); ++i) lanes_[i].progress = now;
  silences_ = 0;
}

void AskLedger::withdraw(const RecordId& id, std::uint32_t from_fragment) {
  Lane& lane = lanes_[id.log.lane];
  for (Ask& ask : lane.asks)
    if (ask.fragment.id == id && ask.fragment.index >= from_fragment) finish(lane, ask);
  trim(lane);
}

void AskLedger::clear() {
  for (Lane& lane : lanes_) {
    lane.asks.clear();
    lane.outstanding = 0;
    lane.progress = {};
    lane.suspect_since.reset();
  }
}

AskLedger::Fragments AskLedger::take_overtaken(Instant now, std::uint8_t lane_index, Duration reorder_window) {
  Fragments lost(memory_);
  Lane& lane = lanes_[lane_index];
  if (!lane.suspect_since || *lane.suspect_since + reorder_window > now) return lost;
  lane.suspect_since.reset();
  for (Ask& ask : lane.asks) {
    if (ask.done || !ask.overtaken_at) continue;
    if (*ask.overtaken_at + reorder_window <= now) {
      lost.push_back(ask.fragment);
      finish(lane, ask);
    } else if (!lane.suspect_since || *ask.overtaken_at < *lane.suspect_since) {
      lane.suspect_since = ask.overtaken_at;
    }
  }
  trim(lane);
  return lost;
}

AskLedger::Fragments AskLedger::take_silent(Instant now, std::uint8_t lane_index, const RoundTrip& round_trip) {
  Fragments lost(memory_);
  Lane& lane = lanes_[lane_index];
  if (lane.outstanding == 0 || lane.progress + round_trip.give_up_after(silences_) > now) return lost;
  for (Ask& ask : lane.asks) {
    if (!ask.done) lost.push_back(ask.fragment);
    finish(lane, ask);
  }
  trim(lane);
  ++silences_;
  return lost;
}

Instant AskLedger::next_deadline(const RoundTrip& round_trip) const {
  Instant next = Instant::max();
  for (const Lane& lane : lanes_) {
    if (lane.outstanding == 0) continue;
    next = std::min(next, lane.progress + round_trip.give_up_after(silences_));
    if (lane.suspect_since) next = std::min(next, *lane.suspect_since + round_trip.reorder_window());
  }
  return next;
}

std::size_t AskLedger::outstanding() const {
  std::size_t sum = 0;
  for (const Lane& lane : lanes_) sum += lane.outstanding;
  return sum;
}

void AskLedger::is_there() { silences_ = std::min(silences_, RoundTrip::kPatientSilences); }

void AskLedger::finish(Lane& lane, Ask& ask) {
  if (!ask.done) --lane.outstanding;
  ask.done = true;
}

void AskLedger::trim(Lane& lane) {
  while (!lane.asks.empty() && lane.asks.front().done) lane.asks.pop_front();
  if (lane.outstanding == 0) lane.suspect_since.reset();
}

}  // namespace onemap::comms
