#pragma once
#include <cstddef>
#include <map>

#include "comms/identity.hpp"
#include "hal/base/ids.hpp"

namespace onemap::comms {

// Which key belongs to which robot's name: the first one that proved itself under it (trust on first use). Whoever owns
// this keeps it over restarts.
class Pins {
 public:
  static constexpr std::size_t kMost = 1024;
  enum class Verdict { known, unknown, another, full };
  Verdict look(const RobotId& robot, const PublicKey& key) const;  // unknown: it may be pinned
  void pin(const RobotId& robot, const PublicKey& key);            // of a robot that has none
  const std::map<RobotId, PublicKey>& all() const { return keys_; }

 private:
  std::map<RobotId, PublicKey> keys_;
};

}  // namespace onemap::comms
