#include "daemon/identity_file.hpp"

#include <filesystem>

#include "control/key_file.hpp"

namespace onemap::daemon {

Result<comms::Identity> open_identity(const std::string& out, Log& log) {
  const std::string file = out + "/identity";
  std::error_code none;
  if (std::filesystem::exists(file, none)) {
    const auto seed = control::read_secret(file, control::kIdentityKind);
    if (!seed)
      return Error{seed.error().place, seed.error().reason +
                                           "; without this file others take this robot for "
                                           "another one of its name"};
    return comms::Identity(seed->bytes);
  }
  const auto seed = control::new_secret();
  if (!seed) return seed.error();
  if (auto kept = control::write_secret(file, control::kIdentityKind, *seed, control::Replace::no); !kept)
    log.warn("{}; this robot's key is lost when it stops, and others will take it for another one; make OUT writable",
             kept.error().text());
  return comms::Identity(seed->bytes);
}

}  // namespace onemap::daemon
