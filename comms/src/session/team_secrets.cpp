#include "session/team_secrets.hpp"

#include <sodium.h>

#include <string_view>

namespace onemap::comms {

namespace {
Secret32 derived(const TeamKey& team, std::string_view label) {
  Secret32 out;
  crypto_generichash_blake2b(out.bytes.data(), out.bytes.size(), reinterpret_cast<const std::uint8_t*>(label.data()),
                             label.size(), team.bytes.data(), team.bytes.size());
  return out;
}
}  // namespace

TeamSecrets::TeamSecrets(const TeamKey& team)
    : psk(derived(team, "onemap 2 psk")),
      mac(derived(team, "onemap 2 mac")),
      cookie(derived(team, "onemap 2 cookie")),
      group(derived(team, "onemap 2 group")) {}

Mac mac_of(Bytes key, Bytes bytes) {
  Mac mac;
  crypto_generichash_blake2b(mac.data(), mac.size(), bytes.data(), bytes.size(), key.data(), key.size());
  return mac;
}

}  // namespace onemap::comms
