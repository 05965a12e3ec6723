#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "comms/datagram_port.hpp"
#include "comms/endpoint.hpp"
#include "hal/base/result.hpp"

namespace onemap::comms {

// "127.0.0.1:7400" or "[::1]:7400"; the error's place is the text, its reason says which part is wrong and why.
// Port 0 is accepted (any free port, for listening). Host names are not looked up.
Result<Endpoint> parse_endpoint(std::string_view text);
std::string to_string(const Endpoint& endpoint);

struct UdpConfig {
  Endpoint listen;  // port 0: any
  // Also hear this multicast group, TTL 1, on the listening address's interface, else where the routes lead: found anew
  // whenever something is sent to it, so that a network may come and go.
  std::optional<Endpoint> group;
  int receive_buffer_bytes = 4 << 20;  // asked for; the kernel may give less
};

struct UdpCounters {
  std::uint64_t sent = 0, received = 0, send_blocked = 0, send_failed = 0, receive_failed = 0;
};

// A non-blocking UDP socket, IPv4 or IPv6 after the listening address.
class UdpPort final : public DatagramPort {
 public:
  static Result<std::unique_ptr<UdpPort>> open(const UdpConfig& config);
  ~UdpPort() override;
  UdpPort(const UdpPort&) = delete;
  UdpPort& operator=(const UdpPort&) = delete;

  Endpoint local() const override;  // with the real port
  bool send(const OutgoingDatagram& datagram) override;
  bool receive(IncomingDatagram& datagram) override;
  bool wait(Duration at_most) override;
  void wake() override;

  int descriptor() const;  // for a poll loop of the caller's
  const UdpCounters& counters() const;

 private:
  struct Impl;
  explicit UdpPort(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace onemap::comms
