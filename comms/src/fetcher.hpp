#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "comms/counters.hpp"
#include "comms/log_store.hpp"
#include "comms/wire.hpp"
#include "hal/base/time.hpp"
#include "link.hpp"

namespace onemap::comms {

// The pulling half of replication: knows which records are missing, asks one neighbour at a time for their fragments
// within a credit, notices losses, puts records together and stores them in log order.
class Fetcher {
 public:
  using Links = std::map<Endpoint, Link>;
  struct Limits {
    std::size_t credit_bytes, reassembly_bytes;
  };
  // `judge` says at any time whether records of a log may come in (Refusal::count), or why not.
  using Judge = std::function<Refusal(const LogId&)>;
  Fetcher(Limits limits, LogStore& store, Counters& counters, Judge judge);

  void offered(const LogId& log);  // a live neighbour holds more of this log than we do
  void on_data(Instant now, Link& from, const wire::Data& data);
  void on_timer(Instant now, Links& links);  // gives up what is lost or silent
  void plan(Instant now, Links& links);      // asks for what is missing, as far as credit and memory go
  void drop(Link& link);                     // it is gone: ask others
  void abandon(const std::function<bool(const LogId&)>& which);  // logs that nobody shall be asked for any longer
  Instant next_deadline(const Links& links) const;

  struct Stored {
    RecordId id;
    std::uint8_t hops = 0;
  };
  std::vector<Stored> take_stored() { return std::exchange(stored_, {}); }
  std::size_t credit_to_announce() const { return window(0); }
  // Logs of which living neighbours hold more than is here, and how much more.
  std::vector<std::pair<LogId, std::uint32_t>> missing(const Links& links) const;
  std::string store_full() const;  // the store's words, while complete records wait for room in it

 private:
  static constexpr std::uint32_t kMissing = 0, kReceived = 0xFFFFFFFF;  // else: the serial of the ask on its way
  struct Fetch {
    Link* target = nullptr;
    bool known = false;  // kind, size and hash, from the first fragment that came
    bool complete = false;
    std::uint16_t kind = 0;
    std::uint8_t hops = 0;
    std::uint32_t total_bytes = 0;
    std::uint64_t hash = 0;
    std::uint32_t received = 0, missing = 0;
    std::size_t reserved_bytes = 0;
    unsigned bad_bodies = 0;               // complete, with a wrong hash
    Instant not_before{};                  // then it is asked for again
    std::vector<std::uint32_t> fragments;  // state of each; as many as guessed while the size is not known
    std::vector<std::uint8_t> body;
  };
  using Fetches = std::map<RecordId, Fetch>;

  std::size_t window(std::uint8_t lane) const;
  std::uint32_t held(const LogId& log) const;
  std::uint32_t offer(const LogId& log, const Links& links) const;
  void note_need(const RecordId& id, const Fetch& fetch);
  // asking
  void ask(Instant now, Link& link, const RecordId& id, Fetch& fetch);
  void ask_run(Instant now, Link& link, const RecordId& id, Fetch& fetch, std::uint32_t first, std::uint32_t end);
  Link* choose(Instant now, const RecordId& id, Links& links, const Link* other_than = nullptr) const;
  void ask_missing(Instant now, std::uint8_t lane, Links& links);
  void open_more(Instant now, std::uint8_t lane, Links& links);
  bool open(Instant now, const RecordId& id, Links& links);
  // answers
  bool learn(Link& from, const wire::Data& data, Fetch& fetch);
  bool reserve(const RecordId& id, Fetch& fetch, std::uint32_t bytes);
  bool make_room(const RecordId& id, std::size_t bytes);
  void remember_size(const RecordId& id, std::uint32_t bytes);
  void answered(Instant now, Link& from, const RecordId& id, std::uint32_t serial);
  void settle(Instant now, Link& from, const RecordId& id, Fetch& fetch);
  void store_in_order(Instant now, const LogId& log);
  // losses
  void lose_suspects(Instant now, Link& link, std::uint8_t lane);
  void lose_silent(Instant now, Link& link, std::uint8_t lane);
  void lose(AskLane& lane, Ask& ask);
  void retarget(Instant now, Link& silent, Links& links);
  void release(const RecordId& id, Fetch& fetch);                   // takes back all that was asked
  void cut(const RecordId& id, Fetch& fetch, std::uint32_t count);  // takes back what was asked beyond the end
  void restart(const RecordId& id, Fetch& fetch);                   // forgets all that came
  void close(const RecordId& id);                                   // as if never opened; it will be opened again
  void trim(AskLane& lane);

  Limits limits_;
  LogStore& store_;
  Counters& counters_;
  Judge judge_;
  Fetches fetches_;
  std::array<std::set<RecordId>, kLaneCount> needs_;                // with missing fragments
  std::array<std::map<LogId, std::uint32_t>, kLaneCount> lacking_;  // log -> next record to open
  std::array<std::uint32_t, kLaneCount> guess_{1, 1, 4, 8, 8};      // fragments of the next record
  struct Blocked {
    Instant again;
    std::string why;
  };
  std::map<LogId, Blocked> blocked_;         // the store had no room; try again then
  Instant wake_ = Instant::max();            // a fetch is asked for again then
  std::map<RecordId, std::uint32_t> sizes_;  // of records whose fetch was closed for want of room
  std::vector<Stored> stored_;
  std::size_t used_bytes_ = 0;
  std::size_t no_room_for_ = 0;  // looked for in vain since the last plan: so many bytes, and more
  std::uint32_t next_serial_ = 1;
};

}  // namespace onemap::comms
