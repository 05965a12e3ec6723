#include "comms/pins.hpp"

#include <cassert>

namespace onemap::comms {

Pins::Verdict Pins::look(const RobotId& robot, const PublicKey& key) const {
  const auto at = keys_.find(robot);
  if (at != keys_.end()) return at->second == key ? Verdict::known : Verdict::another;
  return keys_.size() < kMost ? Verdict::unknown : Verdict::full;
}

void Pins::pin(const RobotId& robot, const PublicKey& key) {
  assert(keys_.size() < kMost);
  keys_.try_emplace(robot, key);
}

}  // namespace onemap::comms
