#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "comms/endpoint.hpp"
#include "hal/base/time.hpp"

namespace onemap::comms {

inline constexpr std::size_t kMaxDatagramBytes = 1200;  // UDP payload; nothing larger is ever sent or accepted

struct OutgoingDatagram {
  Endpoint to;
  std::size_t size = 0;
  std::array<std::uint8_t, kMaxDatagramBytes> buffer;
  std::span<const std::uint8_t> bytes() const { return {buffer.data(), size}; }
};

struct IncomingDatagram {
  Endpoint from;
  std::size_t size = 0;  // a datagram longer than the buffer is cut; more than kMaxDatagramBytes is refused by the Node
  std::array<std::uint8_t, kMaxDatagramBytes + 80> buffer;
  std::span<const std::uint8_t> bytes() const { return {buffer.data(), size}; }
};

// The seam between the protocol and the network: UdpPort in the daemon, SilentPort without a network. Never blocks but
// in wait(). One thread uses it.
class DatagramPort {
 public:
  virtual ~DatagramPort() = default;
  virtual Endpoint local() const = 0;
  virtual bool send(
      const OutgoingDatagram& datagram) = 0;             // false: not sent (no room, no route); the protocol recovers
  virtual bool receive(IncomingDatagram& datagram) = 0;  // false: nothing is waiting
  virtual bool wait(Duration at_most) = 0;               // true: receive() may have something; false: time is up
  virtual void wake() = 0;  // from any thread: a running or the next wait() returns at once
};

}  // namespace onemap::comms
