#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "comms/keeping.hpp"
#include "hal/base/record.hpp"
#include "memory/log_map.hpp"

namespace onemap::comms {

// Which records later ones of their logs made needless, as the heads of these say (Seal::replaces).
class Replacements {
 public:
  // Two bytes a record say how much later the one in its place came. What lies farther apart keeps its body.
  static constexpr std::uint32_t kFarthest = 0xFFFF;
  explicit Replacements(KeepingOf keeping, Memory& memory = heap())
      : keeping_(std::move(keeping)), later_(memory), written_(&memory), last_(&memory) {}

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
    const bool noted = replaced < seq && seq - replaced <= kFarthest;
    if (noted) {
      std::pmr::vector<std::uint16_t>& later = later_[log];
      while (later.size() <= replaced) append_snugly<std::uint16_t>(later, 0);
      if (later[replaced] == 0) later[replaced] = static_cast<std::uint16_t>(seq - replaced);
    }
    if (keep != Keeping::until_the_next) return std::nullopt;
    const auto [last, first_one] = last_.try_emplace({log, record.kind}, seq);
    if (first_one || std::exchange(last->second, seq) != replaced || !noted) return std::nullopt;
    return RecordId{log, replaced};
  }
  // Which one made this one needless; nothing: it still counts, as far as is known here.
  std::optional<RecordId> instead_of(const RecordId& id) const {
    const auto* const later = later_.find(id.log);
    if (later == nullptr || id.seq >= later->size() || (*later)[id.seq] == 0) return std::nullopt;
    return RecordId{id.log, id.seq + (*later)[id.seq]};
  }

 private:
  KeepingOf keeping_;
  using LastOfKind = std::pmr::map<std::pair<LogId, std::uint16_t>, std::uint32_t>;  // sequence
  LogMap<std::pmr::vector<std::uint16_t>> later_;  // of each record: so much later comes the one in its place; 0: none
  LastOfKind written_, last_;  // of the kinds that count until the next: own ones, and those that were applied
};

}  // namespace onemap::comms
