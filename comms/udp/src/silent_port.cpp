#include "comms/udp/silent_port.hpp"

namespace onemap::comms {

bool SilentPort::send(const OutgoingDatagram& /*datagram*/) { return false; }
bool SilentPort::receive(IncomingDatagram& /*datagram*/) { return false; }

bool SilentPort::wait(Duration at_most) {
  std::unique_lock lock(mutex_);
  condition_.wait_for(lock, at_most, [this] { return woken_; });
  woken_ = false;
  return false;
}

void SilentPort::wake() {
  {
    const std::lock_guard lock(mutex_);
    woken_ = true;
  }
  condition_.notify_one();
}

}  // namespace onemap::comms
