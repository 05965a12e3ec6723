#pragma once
#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "comms/wire/frames.hpp"
#include "hal/base/record.hpp"
#include "hal/base/time.hpp"
#include "memory/memory.hpp"

namespace onemap::comms {

// Own records of the lanes that cannot wait (control, poses), each in one fragment, that go to one neighbour unasked:
// as often as its loss makes necessary, a little apart, because losses come in bursts. What is lost all the same it
// will ask for.
class PushQueue {
 public:
  static constexpr std::size_t kMost = 16;  // more at once are no news: they are asked for
  static constexpr auto kApart = std::chrono::milliseconds(4);
  // Copies so that one of 500 records is lost or fewer, three at most.
  static unsigned copies(double loss);
  struct Whole {  // a record's payload, shared by all neighbours' queues
    RecordId id;
    std::uint16_t kind = 0;
    std::uint64_t hash = 0;
    std::pmr::vector<std::uint8_t> payload;
  };
  explicit PushQueue(Memory& memory = heap()) : waiting_(&memory) {}
  bool push(std::shared_ptr<const Whole> record, Instant now, double loss);  // false: full
  bool due(Instant now) const { return !waiting_.empty() && waiting_.front().at <= now; }
  Instant next() const { return waiting_.empty() ? Instant::max() : waiting_.front().at; }
  wire::Data front() const;  // of what is due; valid until sent
  void sent(Instant now);    // the front
  bool holds(const RecordId& id) const;
  void clear() { waiting_.clear(); }

 private:
  struct Push {
    Instant at{};
    std::shared_ptr<const Whole> record;
    unsigned copies = 0;  // still to be sent
  };
  std::pmr::deque<Push> waiting_;  // in the order of `at`
};

}  // namespace onemap::comms
