#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "comms/secret.hpp"
#include "hal/base/result.hpp"

// The team's key, and its like: secrets of 32 bytes in files that only their owner reads: one line, `KIND
// 64-hexadecimal-digits`.
namespace onemap::control {

inline constexpr std::string_view kTeamKeyKind = "onemap-team-key-1";
inline constexpr std::string_view kTeamKeyFile = "/etc/onemap/team.key";

// A file that others may read or write is refused, with what to do. So is one that is no such line.
Result<comms::Secret32> read_secret(const std::string& file, std::string_view kind);

enum class Replace : bool { no, yes };
// Mode 0600, whole or not at all. What there is is replaced only if that is said. Written by root below /etc/onemap it
// belongs to the user onemap, whom the service runs as, if there is one.
Status write_secret(const std::string& file, std::string_view kind, const comms::Secret32& secret, Replace replace);

std::string secret_line(std::string_view kind, const comms::Secret32& secret);  // without the line's end
Result<comms::Secret32> parse_secret(const std::string& line, std::string_view kind);

Status fill_random(std::span<std::uint8_t> bytes);  // by the kernel, which can be missing it at boot only
Result<comms::Secret32> new_secret();

}  // namespace onemap::control
