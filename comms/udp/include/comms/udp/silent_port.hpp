#pragma once
#include <condition_variable>
#include <mutex>

#include "comms/datagram_port.hpp"

namespace onemap::comms {

// The port of a robot without a network: it hears nobody and sends nothing.
class SilentPort final : public DatagramPort {
 public:
  Endpoint local() const override { return {}; }
  bool send(const OutgoingDatagram& datagram) override;
  bool receive(IncomingDatagram& datagram) override;
  bool wait(Duration at_most) override;
  void wake() override;

 private:
  std::mutex mutex_;
  std::condition_variable condition_;
  bool woken_ = false;
};

}  // namespace onemap::comms
