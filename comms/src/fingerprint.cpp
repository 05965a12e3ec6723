#include "comms/fingerprint.hpp"

#include <sodium.h>

#include <string_view>

namespace onemap::comms {

namespace {
std::string digits_of(Bytes key, std::string_view label) {
  std::array<std::uint8_t, 16> hash;
  crypto_generichash_blake2b(hash.data(), hash.size(), reinterpret_cast<const std::uint8_t*>(label.data()),
                             label.size(), key.data(), key.size());
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (std::size_t i = 0; i < 8; ++i) {
    if (i != 0 && i % 2 == 0) text += '-';
    text += kDigits[hash[i] >> 4];
    text += kDigits[hash[i] & 15];
  }
  return text;
}
}  // namespace

std::string fingerprint(const TeamKey& team) { return digits_of(team.bytes, "onemap 2 fingerprint"); }
std::string fingerprint(const PublicKey& robot) { return digits_of(robot, "onemap 2 robot"); }

}  // namespace onemap::comms
