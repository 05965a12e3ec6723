#pragma once
#include <array>
#include <cstddef>
#include <map>
#include <optional>

#include "comms/identity.hpp"
#include "hal/base/time.hpp"
#include "memory/memory.hpp"

namespace onemap::comms {

// Who has proved who it is and speaks nonsense all the same: eight datagrams of it within a minute shut a robot out for
// a minute, the next time for two, and so on up to an hour.
class Conduct {
 public:
  explicit Conduct(Memory& memory = heap()) : records_(&memory) {}
  static constexpr std::size_t kStrikes = 8;
  static constexpr Duration kWithin = std::chrono::minutes(1), kFirstPenalty = std::chrono::minutes(1),
                            kLongestPenalty = std::chrono::hours(1);
  // The penalty, when this was one too many.
  std::optional<Duration> strike(Instant now, const PublicKey& who);
  bool shut_out(Instant now, const PublicKey& who) const;

 private:
  static constexpr std::size_t kMost = 256;  // robots of whom this is known
  struct Record {
    std::array<Instant, kStrikes> strikes{};  // the latest ones, the last of all first
    std::size_t count = 0;
    Instant until{};
    Duration next_penalty = kFirstPenalty;
  };
  std::pmr::map<PublicKey, Record> records_;
};

}  // namespace onemap::comms
