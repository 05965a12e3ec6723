#pragma once
#include <cstdint>
#include <map>
#include <vector>

#include "hal/base/record.hpp"

namespace onemap::comms {

// Where a record lies, in eight bytes.
struct RecordPlace {
  std::uint32_t segment = 0;  // below 2^24
  std::uint32_t at = 0;       // in the segment, a multiple of 16; below 2^26
  bool dropped = false;       // its body counts for nothing any more
  bool in_memory = false;     // not on the disk: its place is with the records that wait
  bool absent = false;        // not found yet, while the disk is read at the start
  std::uint64_t packed() const {
    return (std::uint64_t{segment} << 24) | (at >> 4) | (std::uint64_t{dropped} << 48) |
           (std::uint64_t{in_memory} << 49) | (std::uint64_t{absent} << 50);
  }
  static RecordPlace of(std::uint64_t bits) {
    return {static_cast<std::uint32_t>(bits >> 24) & 0xFFFFFFu, static_cast<std::uint32_t>(bits & 0xFFFFFFu) << 4,
            (bits >> 48 & 1) != 0, (bits >> 49 & 1) != 0, (bits >> 50 & 1) != 0};
  }
  bool operator==(const RecordPlace&) const = default;
};

// The places of all records, log by log, in a block of memory that is taken once: eight bytes a record, in chunks of 64
// that belong to one log each.
class RecordIndex {
 public:
  static constexpr std::size_t kChunk = 64;
  explicit RecordIndex(std::size_t bytes) : places_(bytes / sizeof(std::uint64_t) / kChunk * kChunk) {}

  bool has_room_for(const LogId& log) const { return count(log) % kChunk != 0 || used_ + kChunk <= places_.size(); }
  void push(const LogId& log, const RecordPlace& place) {  // has_room_for it
    Log& entry = logs_[log];
    if (entry.count % kChunk == 0) {
      entry.chunks.push_back(static_cast<std::uint32_t>(used_));
      used_ += kChunk;
    }
    ++entry.count;
    at(entry, entry.count - 1) = place.packed();
  }
  std::uint32_t count(const LogId& log) const {
    const auto found = logs_.find(log);
    return found == logs_.end() ? 0 : found->second.count;
  }
  bool holds(const RecordId& id) const { return id.seq < count(id.log); }
  RecordPlace get(const RecordId& id) const {  // holds it
    const Log& log = logs_.find(id.log)->second;
    return RecordPlace::of(places_[log.chunks[id.seq / kChunk] + id.seq % kChunk]);
  }
  void set(const RecordId& id, const RecordPlace& place) { at(logs_.find(id.log)->second, id.seq) = place.packed(); }
  // While the disk is read: places up to this one, absent ones among them. False: there is no room for so many.
  bool reach(const RecordId& id) {
    while (count(id.log) <= id.seq) {
      if (!has_room_for(id.log)) return false;
      RecordPlace absent;
      absent.absent = true;
      push(id.log, absent);
    }
    return true;
  }
  // Ends each log at its first absent place; how many are behind it, in all.
  std::uint64_t end_at_absent() {
    std::uint64_t beyond = 0;
    for (auto& [log, entry] : logs_) {
      std::uint32_t seq = 0;
      while (seq < entry.count && !RecordPlace::of(at(entry, seq)).absent) ++seq;
      for (std::uint32_t k = seq; k < entry.count; ++k) beyond += RecordPlace::of(at(entry, k)).absent ? 0 : 1;
      entry.count = seq;
      entry.chunks.resize((seq + kChunk - 1) / kChunk);
    }
    std::erase_if(logs_, [](const auto& log) { return log.second.count == 0; });
    return beyond;
  }
  template <class Visit>
  void each_log(Visit visit) const {
    for (const auto& [log, entry] : logs_) visit(log, entry.count);
  }
  std::size_t capacity_bytes() const { return places_.size() * sizeof(std::uint64_t); }

 private:
  struct Log {
    std::vector<std::uint32_t> chunks;
    std::uint32_t count = 0;
  };
  std::uint64_t& at(const Log& log, std::uint32_t seq) { return places_[log.chunks[seq / kChunk] + seq % kChunk]; }
  std::vector<std::uint64_t> places_;
  std::size_t used_ = 0;
  std::map<LogId, Log> logs_;
};

}  // namespace onemap::comms
