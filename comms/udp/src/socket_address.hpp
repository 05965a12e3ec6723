#pragma once
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstring>

#include "comms/endpoint.hpp"

namespace onemap::comms {

// An Endpoint as the kernel wants it, for a socket of the given family. An IPv6 socket takes IPv4 in its mapped form.
struct SocketAddress {
  sockaddr_storage storage{};
  socklen_t size = sizeof(sockaddr_storage);
  sockaddr* raw() { return reinterpret_cast<sockaddr*>(&storage); }
  const sockaddr* raw() const { return reinterpret_cast<const sockaddr*>(&storage); }

  static SocketAddress of(const Endpoint& endpoint, int family) {
    SocketAddress out;
    if (family == AF_INET) {
      sockaddr_in v4{};
      v4.sin_family = AF_INET;
      v4.sin_port = htons(endpoint.port);
      std::memcpy(&v4.sin_addr, endpoint.address.data() + 12, 4);
      std::memcpy(&out.storage, &v4, out.size = sizeof v4);
    } else {
      sockaddr_in6 v6{};
      v6.sin6_family = AF_INET6;
      v6.sin6_port = htons(endpoint.port);
      std::memcpy(&v6.sin6_addr, endpoint.address.data(), 16);
      std::memcpy(&out.storage, &v6, out.size = sizeof v6);
    }
    return out;
  }
  Endpoint endpoint() const {
    if (storage.ss_family == AF_INET) {
      sockaddr_in v4{};
      std::memcpy(&v4, &storage, sizeof v4);
      Endpoint out = Endpoint::ipv4(0, 0, 0, 0, ntohs(v4.sin_port));
      std::memcpy(out.address.data() + 12, &v4.sin_addr, 4);
      return out;
    }
    sockaddr_in6 v6{};
    std::memcpy(&v6, &storage, sizeof v6);
    Endpoint out;
    out.port = ntohs(v6.sin6_port);
    std::memcpy(out.address.data(), &v6.sin6_addr, 16);
    return out;
  }
};

}  // namespace onemap::comms
