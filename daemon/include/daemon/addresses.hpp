#pragma once
#include <string>
#include <vector>

#include "comms/endpoint.hpp"
#include "hal/base/result.hpp"

namespace onemap::daemon {

// What can be told of UDP addresses before a socket is open. ADDR:PORT is 10.0.0.2:4600 or [fd00::2]:4600.

bool is_loopback(const comms::Endpoint& endpoint);  // 127.0.0.0/8 or ::1

// An address at which a robot can listen: one host's, or any (0.0.0.0, [::]); port 0 is any port.
Status check_listen(const std::string& address);
// An address of one other host, with a port.
Status check_peer(const std::string& address);

// An IPv4 multicast group with a port, or nothing.
Status check_group(const std::string& address);

// This machine's interfaces (their ports are 0).
struct OwnNetwork {
  std::vector<comms::Endpoint> addresses, broadcasts;
};
OwnNetwork own_network();

// All together: every peer can be reached from the listening socket (empty: 0.0.0.0:0), is named once, and is not this
// robot itself. A group is heard by a socket that listens at an IPv4 address.
Status check_addresses(const std::string& listen, const std::vector<std::string>& peers, const std::string& group,
                       const OwnNetwork& own);

}  // namespace onemap::daemon
