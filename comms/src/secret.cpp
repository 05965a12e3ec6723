#include "comms/secret.hpp"

#include <sodium.h>

namespace onemap::comms {

void wipe(MutableBytes secret) { sodium_memzero(secret.data(), secret.size()); }

bool equal_in_constant_time(Bytes a, Bytes b) {
  return a.size() == b.size() && sodium_memcmp(a.data(), b.data(), a.size()) == 0;
}

}  // namespace onemap::comms
