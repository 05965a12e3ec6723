#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "comms/wire.hpp"
#include "sim/sim_net.hpp"

namespace onemap::comms::sim {

// Somebody near the team who wants it ill: greets under a name of its own, repeats what it heard (under any address),
// repeats it changed, and, where nothing is sealed, lies in well-formed frames. It hears all that is sent near it.
class Hostile final : public Guest {
 public:
  Hostile(std::uint64_t seed, Endpoint own) : random_(seed), own_(own) {}
  void hear(Instant now, const Endpoint& from, const Endpoint& to, std::span<const std::uint8_t> bytes) override;
  Instant next() const override { return silent_ ? Instant::max() : next_; }
  void speak(Instant now, const Send& send) override;
  void fall_silent() { silent_ = true; }
  static RobotId name() { return RobotId::from_name("mallory"); }
  static constexpr std::uint64_t kLife = 7;

 private:
  struct Heard {
    Endpoint from, to;
    std::vector<std::uint8_t> bytes;
  };
  struct Victim {
    std::uint64_t incarnation = 0;
    std::uint32_t counter = 0;
  };
  using Bytes = std::vector<std::uint8_t>;
  const Heard& any_heard() { return heard_[random_.below(heard_.size())]; }
  void greet(const Send& send);
  void answer_wants(const Send& send);
  void repeat(const Send& send);
  void repeat_changed(const Send& send);
  void lie(const Send& send);
  void speak_without_a_key(const Send& send);
  template <class Write>
  void say(const Send& send, const Endpoint& to, Victim& victim, Write write);
  LogId some_log();

  Random random_;
  Endpoint own_;
  bool silent_ = false;
  Instant next_{};
  std::vector<Heard> heard_;
  std::size_t oldest_ = 0;
  std::map<Endpoint, Victim> victims_;
  std::vector<LogId> logs_;  // of others
  std::vector<std::pair<Endpoint, wire::WantEntry>> wants_;
  wire::Decoder decoder_;
};

}  // namespace onemap::comms::sim
