#pragma once
#include <atomic>
#include <functional>
#include <string>

#include "daemon/control/control_actions.hpp"
#include "daemon/radio.hpp"

namespace onemap::daemon {

// The robot's records, as SAVE and LOAD see them.
struct OwnRecords {
  std::function<bool(const Radio::Question& question, const std::atomic<bool>& stop)> ask;  // Radio::ask
  const comms::DiskStore* kept = nullptr;                                                   // Radio::kept
};

// SAVE and LOAD of records, so of a map that robots go on in; for a thread that may wait.
Result<Json> save_records(const OwnRecords& own, const std::string& folder, const std::atomic<bool>& stop);
// As if a neighbour had them: what is not its author's, or too much, is refused, counted and said. What was taken is
// durable, and waited for, so that no more of it is in memory than of what a neighbour sends.
Result<Json> load_records(const OwnRecords& own, const std::string& folder, const std::atomic<bool>& stop);

}  // namespace onemap::daemon
