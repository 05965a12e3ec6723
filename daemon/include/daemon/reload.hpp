#pragma once
#include <string>
#include <vector>

#include "daemon/config.hpp"
#include "daemon/config_key.hpp"

namespace onemap::daemon {

// What became different when the configuration was read again under a running daemon.
struct KeyChange {
  const ConfigKey* key = nullptr;
  std::string before, after;  // as TOML
};
struct ReloadPlan {
  std::vector<KeyChange> live;     // takes effect with apply_reload()
  std::vector<KeyChange> restart;  // stays as it is until the daemon is started again
};

// Compares two configurations key by key, in the order of the table. Where a value is from does not matter.
ReloadPlan plan_reload(const Config& running, const Config& loaded);

// Sets what can be changed live, and nothing else.
void apply_reload(const ReloadPlan& plan, const Config& loaded, Config& running);

// For the log: what took effect, and what waits for a restart.
std::string to_text(const ReloadPlan& plan);

}  // namespace onemap::daemon
