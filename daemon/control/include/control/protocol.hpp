#pragma once
#include <cstddef>
#include <nlohmann/json.hpp>

// The control protocol (onemap-control.7): JSON objects, one a line, each with a `class`.
namespace onemap::control {

using Json = nlohmann::ordered_json;

// Who asks compares the major number; a greater minor number only adds classes and keys.
inline constexpr int kProtocolMajor = 1, kProtocolMinor = 0;
inline constexpr std::size_t kMostLineBytes = 4096;       // of a request, its end not counted
inline constexpr std::size_t kMostClients = 64;           // at once, over the Unix socket and TCP together
inline constexpr std::size_t kMostUnread = 256u << 10;    // bytes that wait for a client when more is to be said
inline constexpr std::size_t kMostAnswerBytes = 8 << 20;  // of one line from the daemon

// An object as a line, its end included; what is no UTF-8 is replaced.
inline std::string line_of(const Json& object) {
  return object.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace onemap::control
