#include "daemon/control/log_actions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <set>
#include <thread>

#include "daemon/clock.hpp"
#include "daemon/saved_log.hpp"
#include "hal/base/text.hpp"

namespace onemap::daemon {

namespace {
constexpr auto kDiskLook = std::chrono::milliseconds(2);

Error ending() { return {"", "the daemon is ending"}; }

// What becomes of the records of a folder.
class Loading {
 public:
  Loading(const OwnRecords& own, SavedLog& saved, const std::atomic<bool>& stop)
      : own_(own), saved_(saved), stop_(stop) {}

  Status load() {
    if (!own_.ask([this](comms::Node& node, comms::LogStore&) { held_ = node.frontier(); }, stop_)) return ending();
    for (auto some = saved_.next(held_); !some.empty(); some = saved_.next(held_)) {
      if (!own_.ask([&](comms::Node& node, comms::LogStore&) { take(node, some); }, stop_)) return ending();
      if (auto kept = make_durable(); !kept) return kept;
    }
    return stop_ ? Status(ending()) : success();
  }

  // Why there is nothing of it here; nothing: there is something.
  std::optional<std::string> nothing_but_refusals() const {
    if (taken_ + known() > 0) return std::nullopt;
    std::string why = "none of its records can be taken:";
    for (const auto& [reason, records] : refused_) why += fmt::format(" {}: {};", words(reason), records);
    why.pop_back();
    return why;
  }

  Json answer(const std::string& folder) const {
    Json refused = Json::object();
    for (const auto& [reason, records] : refused_) refused[std::string(comms::name(reason))] = records;
    return Json{{"path", printable(folder)},
                {"records", saved_.records()},
                {"taken", taken_},
                {"known", known()},
                {"refused", std::move(refused)},
                {"unreadable", saved_.unreadable()},
                {"spoilt_bytes", saved_.spoilt_bytes()}};
  }

 private:
  std::uint64_t known() const {
    std::uint64_t known = saved_.records() - taken_;
    for (const auto& [reason, records] : refused_) known -= records;
    return known;
  }

  // The radio's thread.
  void take(comms::Node& node, std::vector<SavedLog::Entry>& some) {
    for (SavedLog::Entry& entry : some) {
      const RecordId id = entry.record.id;
      if (ended_.contains(id.log) || id.seq < count(node.frontier(), id.log)) continue;
      const auto reason = node.take(now(), std::move(entry.record), entry.by);
      if (reason == comms::Refusal::count) {
        ++taken_;
        last_[id.log] = id.seq;
      } else {
        refused_[reason] += saved_.logs().at(id.log) - id.seq;
        ended_.insert(id.log);
        saved_.skip(id.log);
      }
    }
  }

  Status make_durable() {
    for (bool all = false; !all; std::this_thread::sleep_for(all ? Duration::zero() : kDiskLook)) {
      Status synced = success();
      const auto look = [&](comms::Node&, comms::LogStore& store) {
        synced = store.sync();
        all = std::ranges::all_of(last_, [&](const auto& log) { return store.durable(log.first) > log.second; });
      };
      if (!own_.ask(look, stop_)) return ending();
      if (!all && !synced) return Error{"", fmt::format("{}; {} records were taken", synced.error().text(), taken_)};
    }
    last_.clear();
    return success();
  }

  static std::uint32_t count(const VersionVector& logs, const LogId& log) {
    const auto at = logs.find(log);
    return at == logs.end() ? 0 : at->second;
  }

  const OwnRecords& own_;
  SavedLog& saved_;
  const std::atomic<bool>& stop_;
  VersionVector held_;
  std::map<LogId, std::uint32_t> last_;  // that were taken and are not known to be durable: sequence
  std::set<LogId> ended_;                // by a refusal; what follows it has no place
  std::uint64_t taken_ = 0;
  std::map<comms::Refusal, std::uint64_t> refused_;  // records
};
}  // namespace

Result<Json> save_records(const OwnRecords& own, const std::string& folder, const std::atomic<bool>& stop) {
  if (own.kept == nullptr)
    return Error{"", "this robot keeps no log on its disk (store.keep), so there is none to save"};
  VersionVector logs;
  if (!own.ask([&](comms::Node&, comms::LogStore& store) { logs = durable_part(store); }, stop)) return ending();
  const auto durable = [&](const LogId& log) {
    std::uint32_t now = 0;
    const auto look = [&](comms::Node&, comms::LogStore& store) {
      const auto at = store.frontier().find(log);
      now = at == store.frontier().end() ? 0 : std::min(at->second, store.durable(log));
    };
    return own.ask(look, stop) ? now : 0;
  };
  const auto saved = SavedLog::save(*own.kept, logs, folder, stop, durable);
  if (!saved) return saved.error();
  return Json{
      {"path", printable(folder)}, {"records", saved->records}, {"bytes", saved->bytes}, {"left_out", saved->left_out}};
}

Result<Json> load_records(const OwnRecords& own, const std::string& folder, const std::atomic<bool>& stop) {
  const auto saved = SavedLog::open(folder, stop);
  if (!saved) return stop ? ending() : saved.error();
  Loading loading(own, **saved, stop);
  if (auto loaded = loading.load(); !loaded) return loaded.error();
  if (auto none = loading.nothing_but_refusals()) return Error{printable(folder), *none};
  return loading.answer(folder);
}

}  // namespace onemap::daemon
