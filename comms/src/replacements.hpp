#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "comms/keeping.hpp"
#include "hal/base/record.hpp"

namespace onemap::comms {

// Which records later ones of their logs made needless, as the heads of these say (Seal::replaces).
class Replacements {
 public:
  explicit Replacements(KeepingOf keeping) : keeping_(std::move(keeping)) {}

  Keeping keeping(std::uint16_t kind) const { return keeping_ ? keeping_(kind) : Keeping::always; }
  // Which one the next own record of this kind makes needless by itself: the one before it.
  std::uint32_t before(const LogId& log, std::uint16_t kind) const {
    const auto last = written_.find({log, kind});
    return last == written_.end() ? kNoSequence : last->second;
  }
  void wrote(const RecordId& id, std::uint16_t kind) {
    if (keeping(kind) == Keeping::until_the_next) written_[{id.log, kind}] = id.seq;
  }
  // Records of one log in their order. Whose body may go at once; nothing: none's.
  std::optional<RecordId> took(const Record& record) {
    const Keeping keep = keeping(record.kind);
    if (keep == Keeping::always) return std::nullopt;
    const auto& [log, seq] = record.id;
    const std::uint32_t replaced = record.seal.replaces;
    if (replaced < seq) {
      std::vector<std::uint32_t>& by = by_[log];
      if (by.size() <= replaced) by.resize(replaced + 1, 0);
      if (by[replaced] == 0) by[replaced] = seq;
    }
    if (keep != Keeping::until_the_next) return std::nullopt;
    const auto [last, first_one] = last_.try_emplace({log, record.kind}, seq);
    if (first_one || std::exchange(last->second, seq) != replaced) return std::nullopt;
    return RecordId{log, replaced};
  }
  // Which one made this one needless; nothing: it still counts, as far as is known here.
  std::optional<RecordId> instead_of(const RecordId& id) const {
    const auto by = by_.find(id.log);
    if (by == by_.end() || id.seq >= by->second.size() || by->second[id.seq] == 0) return std::nullopt;
    return RecordId{id.log, by->second[id.seq]};
  }

 private:
  KeepingOf keeping_;
  using LastOfKind = std::map<std::pair<LogId, std::uint16_t>, std::uint32_t>;  // sequence
  std::map<LogId, std::vector<std::uint32_t>> by_;                              // of each sequence; 0: none
  LastOfKind written_, last_;  // of the kinds that count until the next: own ones, and those that were applied
};

}  // namespace onemap::comms
