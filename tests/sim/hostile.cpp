#include "sim/hostile.hpp"

#include <algorithm>

namespace onemap::comms::sim {

namespace {
constexpr std::size_t kRemembers = 64, kLogs = 32, kWants = 32;
}  // namespace

void Hostile::hear(Instant, const Endpoint& from, const Endpoint& to, std::span<const std::uint8_t> bytes) {
  Heard heard{from, to, {bytes.begin(), bytes.end()}};
  if (heard_.size() < kRemembers)
    heard_.push_back(std::move(heard));
  else
    heard_[oldest_++ % kRemembers] = std::move(heard);
  if (decoder_.decode(bytes) != Refusal::count) return;
  victims_[from].incarnation = decoder_.header().sender;
  for (const wire::Frame& frame : decoder_.frames()) {
    if (const auto* have = std::get_if<wire::Have>(&frame))
      for (const wire::HaveEntry& entry : have->entries)
        if (logs_.size() < kLogs) logs_.push_back(entry.log);
    if (const auto* want = std::get_if<wire::Want>(&frame); want != nullptr && to == own_)
      for (const wire::WantEntry& entry : want->entries)
        if (wants_.size() < kWants) wants_.emplace_back(from, entry);
  }
}

void Hostile::speak(Instant now, const Send& send) {
  next_ = now + std::chrono::milliseconds(5 + random_.below(120));
  if (silent_ || heard_.empty()) return;
  if (victims_.empty()) return speak_without_a_key(send);
  switch (random_.below(6)) {
    case 0:
      return greet(send);
    case 1:
      return answer_wants(send);
    case 2:
      return repeat(send);
    case 3:
      return repeat_changed(send);
    default:
      return lie(send);
  }
}

// All that is said near it is sealed.
void Hostile::speak_without_a_key(const Send& send) {
  if (random_.below(3) == 0) return repeat_changed(send);
  repeat(send);
}

template <class Write>
void Hostile::say(const Send& send, const Endpoint& to, Victim& victim, Write write) {
  std::array<std::uint8_t, kMaxDatagramBytes> buffer{};
  wire::Encoder out(buffer, {wire::DatagramType::unicast, kLife, victim.incarnation, ++victim.counter});
  write(out);
  send(own_, to, std::span(buffer).first(out.size()));
}

void Hostile::greet(const Send& send) {
  for (auto& [endpoint, victim] : victims_)
    say(send, endpoint, victim, [&](wire::Encoder& out) {
      out.beacon({name(), random_.next(), random_.next(), victim.counter + 1, 0});
      if (random_.below(2) == 0) out.pong(static_cast<std::uint32_t>(random_.next()));
    });
}

// With bodies that are not what their hash says, and with parts that contradict each other.
void Hostile::answer_wants(const Send& send) {
  for (const auto& [endpoint, entry] : wants_) {
    wire::Data data;
    data.id = entry.id;
    data.kind = static_cast<std::uint16_t>(random_.below(9));
    const Bytes body(random_.below(wire::kFragmentBytes), static_cast<std::uint8_t>(random_.next()));
    data.total_bytes = static_cast<std::uint32_t>(body.size());
    data.body_hash = random_.next();
    data.bytes = body;
    say(send, endpoint, victims_[endpoint], [&](wire::Encoder& out) { out.data(data); });
  }
  wants_.clear();
}

void Hostile::repeat(const Send& send) {
  for (std::size_t k = 1 + random_.below(8); k > 0; --k) {
    const Heard& heard = any_heard();
    const Endpoint to = heard.to == own_ || random_.below(4) == 0 ? any_heard().from : heard.to;
    send(random_.below(3) == 0 ? own_ : heard.from, to, heard.bytes);
  }
}

void Hostile::repeat_changed(const Send& send) {
  const Heard& heard = any_heard();
  Bytes bytes = heard.bytes;
  switch (random_.below(4)) {
    case 0:
      bytes.resize(random_.below(bytes.size() + 1));
      break;
    case 1: {
      const Bytes& other = any_heard().bytes;
      const std::size_t at = std::min({wire::kHeaderBytes + random_.below(40), bytes.size(), other.size()});
      bytes.resize(at);
      bytes.insert(bytes.end(), other.begin() + static_cast<std::ptrdiff_t>(at), other.end());
      break;
    }
    default:
      for (std::size_t k = 1 + random_.below(4); k > 0 && !bytes.empty(); --k)
        bytes[random_.below(bytes.size())] = static_cast<std::uint8_t>(random_.next());
  }
  const Endpoint to = heard.to == own_ ? any_heard().from : heard.to;
  send(random_.below(2) == 0 ? own_ : heard.from, to, bytes);
}

LogId Hostile::some_log() {
  if (!logs_.empty() && random_.below(3) != 0) return logs_[random_.below(logs_.size())];
  const auto lane = static_cast<std::uint8_t>(random_.below(kLaneCount));
  return {random_.below(2) == 0 ? name() : numbered("ghost", random_.below(50)), lane, 1 + random_.below(9)};
}

void Hostile::lie(const Send& send) {
  auto at = victims_.begin();
  std::advance(at, random_.below(victims_.size()));
  auto& [endpoint, victim] = *at;
  say(send, endpoint, victim, [&](wire::Encoder& out) {
    switch (random_.below(5)) {
      case 0: {
        std::vector<wire::HaveEntry> entries;
        for (std::size_t k = 1 + random_.below(20); k > 0; --k)
          entries.push_back(
              {some_log(), static_cast<std::uint32_t>(1 + random_.below(random_.below(2) == 0 ? 10 : 0xFFFFFFFF))});
        out.have(random_.next(), entries);
        break;
      }
      case 1: {
        std::vector<wire::WantEntry> entries;
        for (std::size_t k = 1 + random_.below(30); k > 0; --k)
          entries.push_back({{some_log(), static_cast<std::uint32_t>(random_.below(6))}, 0, 0xFFFF});
        out.want(static_cast<std::uint32_t>(random_.below(4000)), entries);
        break;
      }
      case 2: {
        std::vector<RobotStatus> robots;
        for (std::size_t k = 1 + random_.below(20); k > 0; --k)
          robots.push_back({some_log().robot, 1 + random_.below(5000), static_cast<std::uint32_t>(random_.next()),
                            random_.next(), random_.next(), 1});
        out.status(robots);
        break;
      }
      case 3:
        out.have_request();
        out.ping(static_cast<std::uint32_t>(random_.next()));
        break;
      default:
        out.beacon({some_log().robot, random_.next(), random_.next(), 1, 1});
    }
  });
}

}  // namespace onemap::comms::sim
