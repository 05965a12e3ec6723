#pragma once
#include <functional>
#include <optional>

#include "comms/endpoint.hpp"
#include "hal/base/time.hpp"
#include "session/sealed_wire.hpp"
#include "session/team_secrets.hpp"

namespace onemap::comms {

// Bytes that nobody can guess, from whoever has a source of them.
using RandomBytes = std::function<void(MutableBytes)>;

// A responder's cookies: under load it does no work for an address that has not shown that it receives there. A cookie
// is a MAC of the address by a secret that changes every two minutes, so nothing is kept about who asked.
class CookieJar {
 public:
  static constexpr Duration kLife = std::chrono::minutes(2);
  bool pays(Instant now, const Endpoint& from, Bytes hello) const;  // its second MAC is by its cookie
  std::array<std::uint8_t, sealed::kCookieBytes> reply(Instant now, const Endpoint& from, Bytes hello,
                                                       const Secret32& seal, const RandomBytes& random);

 private:
  Mac cookie_of(const Endpoint& from) const;
  Secret32 secret_;
  std::optional<Instant> made_;
};

// An initiator's side.
std::optional<Mac> open_cookie(Bytes reply, const Secret32& seal, const Mac& mac1);
void pay(MutableBytes hello, const Mac& cookie);

}  // namespace onemap::comms
