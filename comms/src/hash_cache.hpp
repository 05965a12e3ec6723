#pragma once
#include <cstdint>
#include <map>

#include "comms/wire/payload.hpp"
#include "hal/base/record.hpp"
#include "memory/memory.hpp"

namespace onemap::comms {

// Hashes of the payloads of records that were served lately: a record is served fragment by fragment, and its hash goes
// with each.
class HashCache {
 public:
  static constexpr std::size_t kCapacity = 1024;
  explicit HashCache(Memory& memory = heap()) : hashes_(&memory) {}
  std::uint64_t of(const Record& record) {
    const auto at = hashes_.find(record.id);
    if (at != hashes_.end()) return at->second;
    if (hashes_.size() >= kCapacity) hashes_.clear();
    return hashes_[record.id] = wire::payload_hash(record);
  }
  std::size_t size() const { return hashes_.size(); }

 private:
  std::pmr::map<RecordId, std::uint64_t> hashes_;
};

}  // namespace onemap::comms
