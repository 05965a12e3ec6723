#include <arpa/inet.h>
#include <fmt/format.h>

#include <charconv>

#include "comms/udp/udp_port.hpp"

namespace onemap::comms {

namespace {
Error wrong(std::string_view text, std::string reason) {
  return {fmt::format("endpoint \"{}\"", text), std::move(reason)};
}

bool parse_address(const std::string& text, bool bracketed, Endpoint& out) {
  if (bracketed) return inet_pton(AF_INET6, text.c_str(), out.address.data()) == 1;
  out = Endpoint::ipv4(0, 0, 0, 0, out.port);
  return inet_pton(AF_INET, text.c_str(), out.address.data() + 12) == 1;
}
}  // namespace

Result<Endpoint> parse_endpoint(std::string_view text) {
  const auto colon = text.rfind(':');
  if (colon == std::string_view::npos) return wrong(text, "no port; expected ADDRESS:PORT, such as 127.0.0.1:7400");
  std::string_view address = text.substr(0, colon);
  const std::string_view port = text.substr(colon + 1);
  Endpoint endpoint;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), endpoint.port);
  if (port.empty() || error != std::errc{} || end != port.data() + port.size())
    return wrong(text, fmt::format("port \"{}\" is not a number from 0 to 65535", port));
  const bool bracketed = address.size() >= 2 && address.front() == '[' && address.back() == ']';
  if (bracketed) address = address.substr(1, address.size() - 2);
  if (!bracketed && address.find(':') != std::string_view::npos)
    return wrong(text, "an IPv6 address needs brackets, such as [::1]:7400");
  if (!parse_address(std::string(address), bracketed, endpoint))
    return wrong(text, fmt::format("\"{}\" is not a numeric IPv{} address", address, bracketed ? 6 : 4));
  return endpoint;
}

std::string to_string(const Endpoint& endpoint) {
  const auto& a = endpoint.address;
  if (endpoint.is_ipv4()) return fmt::format("{}.{}.{}.{}:{}", a[12], a[13], a[14], a[15], endpoint.port);
  char text[INET6_ADDRSTRLEN] = {};
  inet_ntop(AF_INET6, a.data(), text, sizeof text);
  return fmt::format("[{}]:{}", static_cast<const char*>(text), endpoint.port);
}

}  // namespace onemap::comms
