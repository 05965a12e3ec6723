#pragma once
#include <cstdint>
#include <optional>

#include "comms/counters.hpp"
#include "hal/base/time.hpp"
#include "session/greeting.hpp"
#include "session/noise/handshake.hpp"
#include "session/replay_window.hpp"
#include "session/sealed_wire.hpp"

namespace onemap::comms {

// A session that a handshake made: two keys, who is at the other end, and which counters were used and seen. The keys
// are wiped when it goes.
class Transport {
 public:
  static constexpr Duration kRekeyAfter = std::chrono::seconds(120), kRejectAfter = std::chrono::seconds(180);
  static constexpr std::uint64_t kRekeyAfterDatagrams = std::uint64_t{1} << 32;

  struct Ends {
    noise::Role role;
    std::uint32_t own_index = 0, their_index = 0;
    Greeting peer;
  };
  Transport(Instant begun, const Ends& ends, const noise::Handshake& ended);

  const Greeting& peer() const { return ends_.peer; }
  noise::Role role() const { return ends_.role; }
  std::uint32_t own_index() const { return ends_.own_index; }
  std::uint32_t their_index() const { return ends_.their_index; }
  Instant begun() const { return begun_; }
  bool expired(Instant now) const { return now - begun_ >= kRejectAfter; }
  bool worn(Instant now) const { return now - begun_ >= kRekeyAfter || sealed_ >= kRekeyAfterDatagrams; }
  double loss() const { return window_.loss(); }
  const noise::Key& sending_key() const { return sending_; }
  const noise::Key& receiving_key() const { return receiving_; }

  // Seals `size` bytes that stand behind the header's room; the datagram's size. `counter` is the writer's own count of
  // datagrams to there (32 bits, going round); the number that is sent has it as its low half, unless that would use a
  // number a second time.
  std::size_t seal(MutableBytes datagram, std::size_t size, std::uint32_t counter);
  std::size_t say(MutableBytes datagram, sealed::Word word, std::uint64_t token);

  // Opens a datagram of this session into `plain` and shows its counter to the window: Refusal::count when it is good.
  Refusal open(Bytes datagram, MutableBytes plain);
  struct Said {
    sealed::Word word;
    std::uint64_t token;
  };
  Refusal hear(Bytes datagram, Said& said);
  bool is_newest(std::uint64_t counter) const { return counter == window_.highest(); }

 private:
  Instant begun_;
  Ends ends_;
  noise::Key sending_, receiving_;
  std::uint64_t last_ = 0, sealed_ = 0;          // frames sent
  std::uint64_t own_last_ = 0, their_last_ = 0;  // words sent and heard
  ReplayWindow window_;
};

}  // namespace onemap::comms
