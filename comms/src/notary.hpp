#pragma once
#include <map>
#include <optional>
#include <set>

#include "comms/counters.hpp"
#include "comms/log_store.hpp"
#include "comms/record_head.hpp"
#include "memory/memory.hpp"

namespace onemap::comms {

// Whose signature counts under which name, and where each log's chain ends: what decides whether a record that came is
// its author's. A robot's key is the one that the first log taken up of it names; nobody has another one later.
class Notary {
 public:
  explicit Notary(Memory& memory = heap()) : keys_(&memory), ends_(&memory), barred_(&memory) {}
  void start(const LogStore& store);  // what is held was looked at when it came

  struct Verdict {
    Refusal reason = Refusal::count;  // count: it is its author's next record
    Hash hash{};                      // of its head
  };
  // Of a record that is the next of its log.
  Verdict look_at(const Record& record) const;
  // Of a record that is its author's, and came without its body: whether its author wrote `by`, too.
  bool vouches(const Record& record, const SignedHead& by) const;
  // The record was stored; what its seal says of the one before it.
  void took(const RecordId& id, const Hash& previous, const Hash& hash);
  // The author has signed two records of one place: nothing more of this log is worth anything.
  void bar(const LogId& log) { barred_.insert(log); }
  bool barred(const LogId& log) const { return barred_.contains(log); }

  Hash seal_next(Record& own, const Identity& author) const { return seal(own, end_of(own.id.log), author); }
  // A key that somebody vouches for before any record came. False: another one counts already.
  bool pin(const RobotId& robot, const PublicKey& key) { return keys_.try_emplace(robot, key).first->second == key; }
  std::optional<PublicKey> key_of(const RobotId& robot) const;

 private:
  Hash end_of(const LogId& log) const;
  std::pmr::map<RobotId, PublicKey> keys_;
  std::pmr::map<LogId, Hash> ends_;
  std::pmr::set<LogId> barred_;
};

}  // namespace onemap::comms
