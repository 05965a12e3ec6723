#include "daemon/addresses.hpp"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>

#include "comms/udp/udp_port.hpp"

namespace onemap::daemon {

namespace {

using comms::Endpoint;

std::uint8_t first_byte(const Endpoint& e) { return e.address[e.is_ipv4() ? 12 : 0]; }

bool is_any(const Endpoint& e) {
  if (e.is_ipv4()) return std::all_of(e.address.begin() + 12, e.address.end(), [](auto b) { return b == 0; });
  return std::all_of(e.address.begin(), e.address.end(), [](auto b) { return b == 0; });
}

// Why an address is no single host's; empty: it may be one.
std::string no_host(const Endpoint& e) {
  const std::uint8_t first = first_byte(e);
  if (e.is_ipv4()) {
    if (first >= 224 && first < 240) return "is a multicast address";
    if (first >= 240) return first_byte(e) == 255 ? "is the broadcast address" : "is a reserved address";
    if (first == 0 && !is_any(e)) return "is a reserved address";
    return {};
  }
  if (first == 0xFF) return "is a multicast address";
  if (first == 0xFE && (e.address[1] & 0xC0u) == 0x80u) return "is a link-local address, which needs a zone";
  return {};
}

Result<Endpoint> parse(const std::string& text) {
  auto endpoint = comms::parse_endpoint(text);
  if (!endpoint) return Error{"", endpoint.error().text()};
  const std::string why = no_host(*endpoint);
  if (!why.empty()) return Error{"", "\"" + text + "\" " + why};
  return endpoint;
}

Error about(const std::string& peer, const std::string& reason) {
  return {"network.peers", "\"" + peer + "\" " + reason};
}

// From one socket: IPv4 reaches IPv4; IPv6 reaches IPv6, and IPv4 too when it listens at every address.
bool reaches(const Endpoint& listen, const Endpoint& peer) {
  return listen.is_ipv4() == peer.is_ipv4() || (!listen.is_ipv4() && is_any(listen));
}

bool is_self(const Endpoint& listen, const Endpoint& peer, const OwnNetwork& own) {
  if (listen.port == 0 || listen.port != peer.port) return false;
  if (!is_any(listen)) return listen == peer;
  Endpoint host = peer;
  host.port = 0;
  return is_loopback(peer) || std::find(own.addresses.begin(), own.addresses.end(), host) != own.addresses.end();
}

Status check_one(const std::string& text, const Endpoint& peer, const Endpoint& listen, const OwnNetwork& own) {
  if (!reaches(listen, peer))
    return about(text, "cannot be reached: the socket at " + comms::to_string(listen) + " speaks only IPv" +
                           (listen.is_ipv4() ? "4" : "6") + "; listen at [::]:PORT to speak both");
  if (is_self(listen, peer, own))
    return about(text, "is this robot itself, which listens at " + comms::to_string(listen));
  Endpoint host = peer;
  host.port = 0;
  if (std::find(own.broadcasts.begin(), own.broadcasts.end(), host) != own.broadcasts.end())
    return about(text, "is a broadcast address");
  return success();
}

std::optional<Endpoint> endpoint_of(const sockaddr* address) {
  if (!address) return std::nullopt;
  Endpoint endpoint = Endpoint::ipv4(0, 0, 0, 0, 0);
  if (address->sa_family == AF_INET) {
    std::memcpy(endpoint.address.data() + 12, &reinterpret_cast<const sockaddr_in*>(address)->sin_addr, 4);
    return endpoint;
  }
  if (address->sa_family != AF_INET6) return std::nullopt;
  std::memcpy(endpoint.address.data(), &reinterpret_cast<const sockaddr_in6*>(address)->sin6_addr, 16);
  return endpoint;
}

}  // namespace

bool is_loopback(const comms::Endpoint& e) {
  if (e.is_ipv4()) return first_byte(e) == 127;
  return std::all_of(e.address.begin(), e.address.end() - 1, [](auto b) { return b == 0; }) && e.address[15] == 1;
}

Status check_listen(const std::string& address) {
  const auto endpoint = parse(address);
  return endpoint ? success() : endpoint.error();
}

Status check_peer(const std::string& address) {
  const auto endpoint = parse(address);
  if (!endpoint) return endpoint.error();
  if (is_any(*endpoint)) return Error{"", "\"" + address + "\" is no host's address"};
  if (endpoint->port == 0) return Error{"", "\"" + address + "\" has port 0: nobody is there"};
  return success();
}

Status check_group(const std::string& address) {
  if (address.empty()) return success();
  const auto endpoint = comms::parse_endpoint(address);
  if (!endpoint) return Error{"", endpoint.error().text()};
  const bool multicast = endpoint->is_ipv4() && first_byte(*endpoint) >= 224 && first_byte(*endpoint) < 240;
  if (!multicast) return Error{"", "\"" + address + "\" is no IPv4 multicast address (224.0.0.0 to 239.255.255.255)"};
  if (endpoint->port == 0) return Error{"", "\"" + address + "\" has port 0: nobody would meet there"};
  return success();
}

OwnNetwork own_network() {
  OwnNetwork own;
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return own;
  const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> owner(list, ::freeifaddrs);
  for (const ifaddrs* i = list; i; i = i->ifa_next) {
    if (const auto address = endpoint_of(i->ifa_addr)) own.addresses.push_back(*address);
    if ((i->ifa_flags & IFF_BROADCAST) == 0) continue;
    if (const auto broadcast = endpoint_of(i->ifa_broadaddr)) own.broadcasts.push_back(*broadcast);
  }
  return own;
}

Status check_addresses(const std::string& listen, const std::vector<std::string>& peers, const std::string& group,
                       const OwnNetwork& own) {
  const auto at = parse(listen.empty() ? "0.0.0.0:0" : listen);
  if (!at) return Error{"network.listen", at.error().reason};
  if (auto status = check_group(group); !status) return Error{"network.group", status.error().reason};
  if (!group.empty() && !at->is_ipv4())
    return Error{"network.group", "\"" + group + "\" needs an IPv4 socket, and network.listen is " + listen};
  std::vector<Endpoint> known;
  for (const std::string& text : peers) {
    if (auto status = check_peer(text); !status) return Error{"network.peers", status.error().reason};
    const Endpoint peer = *parse(text);
    if (auto status = check_one(text, peer, *at, own); !status) return status;
    if (std::find(known.begin(), known.end(), peer) != known.end()) return about(text, "is given twice");
    known.push_back(peer);
  }
  return success();
}

}  // namespace onemap::daemon
