#pragma once
#include <string>

#include "comms/identity.hpp"
#include "comms/secret.hpp"

namespace onemap::comms {

// Four groups of four hexadecimal digits by which people tell keys apart; of a team's key nothing else can be learnt
// from them.
std::string fingerprint(const TeamKey& team);
std::string fingerprint(const PublicKey& robot);

}  // namespace onemap::comms
