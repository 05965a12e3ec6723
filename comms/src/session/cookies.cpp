#include "session/cookies.hpp"

#include <sodium.h>

#include <algorithm>

#include "hal/base/bytes.hpp"

namespace onemap::comms {

using namespace sealed;

namespace {
constexpr std::size_t kNonceBytes = crypto_aead_xchacha20poly1305_ietf_NPUBBYTES;
static_assert(kCookieNonceAt + kNonceBytes == kCookieSealedAt);
static_assert(kCookieSealedAt + kMacBytes + kTagBytes == kCookieBytes);

// What mac2 is about: all that stands before it.
Mac payment(Bytes hello, const Mac& cookie) { return mac_of(cookie, hello.first(kHelloMac2At)); }
}  // namespace

Mac CookieJar::cookie_of(const Endpoint& from) const {
  std::array<std::uint8_t, 18> place;
  std::copy(from.address.begin(), from.address.end(), place.begin());
  put_little_endian(&place[16], from.port);
  return mac_of(secret_.bytes, place);
}

bool CookieJar::pays(Instant now, const Endpoint& from, Bytes hello) const {
  if (!made_ || now - *made_ >= kLife) return false;
  return equal_in_constant_time(payment(hello, cookie_of(from)), hello.subspan(kHelloMac2At, kMacBytes));
}

std::array<std::uint8_t, kCookieBytes> CookieJar::reply(Instant now, const Endpoint& from, Bytes hello,
                                                        const Secret32& seal, const RandomBytes& random) {
  if (!made_ || now - *made_ >= kLife) {
    random(secret_.bytes);
    made_ = now;
  }
  std::array<std::uint8_t, kCookieBytes> out;
  write_head(out, Type::cookie);
  put_little_endian(&out[kHeadBytes], index_at(hello, kHeadBytes));
  random(MutableBytes(out).subspan(kCookieNonceAt, kNonceBytes));
  const Mac cookie = cookie_of(from);
  crypto_aead_xchacha20poly1305_ietf_encrypt(&out[kCookieSealedAt], nullptr, cookie.data(), cookie.size(),
                                             hello.data() + kHelloMac1At, kMacBytes, nullptr, &out[kCookieNonceAt],
                                             seal.bytes.data());
  return out;
}

std::optional<Mac> open_cookie(Bytes reply, const Secret32& seal, const Mac& mac1) {
  Mac cookie;
  if (crypto_aead_xchacha20poly1305_ietf_decrypt(cookie.data(), nullptr, nullptr, reply.data() + kCookieSealedAt,
                                                 kMacBytes + kTagBytes, mac1.data(), mac1.size(),
                                                 reply.data() + kCookieNonceAt, seal.bytes.data()) != 0)
    return std::nullopt;
  return cookie;
}

void pay(MutableBytes hello, const Mac& cookie) {
  std::ranges::copy(payment(hello, cookie), hello.begin() + kHelloMac2At);
}

}  // namespace onemap::comms
