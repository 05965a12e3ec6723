#include "daemon/reload.hpp"

#include <fmt/format.h>

namespace onemap::daemon {

ReloadPlan plan_reload(const Config& running, const Config& loaded) {
  ReloadPlan plan;
  for (const ConfigKey& key : config_keys()) {
    KeyChange change{&key, toml_text(key.get(running)), toml_text(key.get(loaded))};
    if (change.before == change.after) continue;
    (key.reload == Reload::live ? plan.live : plan.restart).push_back(std::move(change));
  }
  return plan;
}

void apply_reload(const ReloadPlan& plan, const Config& loaded, Config& running) {
  for (const KeyChange& change : plan.live) {
    const std::string name = change.key->full_name();
    // It was accepted when it was loaded.
    if (!change.key->set(change.key->get(loaded), running)) continue;
    running.origins.erase(name);
    if (const auto origin = loaded.origins.find(name); origin != loaded.origins.end()) running.origins.insert(*origin);
  }
}

std::string to_text(const ReloadPlan& plan) {
  std::string text;
  for (const KeyChange& change : plan.live)
    text += fmt::format("{}{} is {} now, was {}", text.empty() ? "" : "; ", change.key->full_name(), change.after,
                        change.before);
  std::string waiting;
  for (const KeyChange& change : plan.restart)
    waiting += fmt::format("{}{} ({} after {})", waiting.empty() ? "" : ", ", change.key->full_name(), change.after,
                           change.before);
  if (!waiting.empty()) text += (text.empty() ? "" : "; ") + ("only a restart changes " + waiting);
  return text.empty() ? "nothing changed" : text;
}

}  // namespace onemap::daemon
