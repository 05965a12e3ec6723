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
#include "comms/keeping.hpp"
#include "comms/log_store.hpp"
#include "comms/wire/frames.hpp"
#include "fetch/assembly.hpp"
#include "hal/base/time.hpp"
#include "held_logs.hpp"
#include "memory/memory.hpp"
#include "notary.hpp"
#include "peer/peer.hpp"

namespace onemap::comms {

// The pulling half of replication: knows which records are missing, asks one neighbour at a time for their fragments
// within a credit, notices losses, puts records together and stores them in log order.
class Fetcher {
 public:
  using Peers = std::pmr::map<Endpoint, Peer>;
  struct Limits {
    std::size_t credit_bytes, most_credit_bytes, reassembly_bytes;
  };
  // Says at any time whether records of a log may come in (Refusal::count), or why not.
  using Judge = std::function<Refusal(const LogId&)>;
  // Of which kinds a later record takes an earlier one's place: nothing else may come without its body.
  Fetcher(Limits limits, LogStore& store, HeldLogs& here, Notary& notary, Counters& counters, Judge judge,
          KeepingOf keeping, Memory& memory);

  void offered(const LogId& log);  // a live neighbour holds more of this log than we do
  void on_data(Instant now, Peer& from, const wire::Data& data);
  void on_head(Instant now, Peer& from, const wire::Head& head);
  // A record that no neighbour sent, the next of its log. Count: it is stored; else why not.
  Refusal take(Instant now, Record record, std::optional<SignedHead> by);
  void on_timer(Instant now, Peers& peers);  // gives up what is lost or silent
  void plan(Instant now, Peers& peers);      // asks for what is missing, as far as credit and memory go
  void drop(Peer& peer);                     // it is gone: ask others
  void abandon(const std::function<bool(const LogId&)>& which);  // logs that nobody shall be asked for any longer
  Instant next_deadline(const Peers& peers) const;

  struct Stored {
    RecordId id;
    std::uint8_t hops = 0;
  };
  using AllStored = std::pmr::vector<Stored>;
  const AllStored& take_stored();  // until it is called again
  std::size_t credit_to_announce(const Peer& peer) const { return window(peer, 0); }
  struct Spoilt {  // a record that is not its author's next one
    RecordId id;
    Refusal reason;
    Endpoint from;  // whose last part it was
  };
  using AllSpoilt = std::pmr::vector<Spoilt>;
  const AllSpoilt& take_spoilt();
  // Logs of which living neighbours hold more than is here, and how much more.
  std::vector<std::pair<LogId, std::uint32_t>> missing(const Peers& peers) const;
  std::uint32_t offer(const LogId& log, const Peers& peers) const;  // the most that a living neighbour holds of it
  std::string store_full() const;  // the store's words, while complete records wait for room in it

 private:
  static constexpr std::uint32_t kMaxGuess = 64;
  struct Fetch {
    explicit Fetch(Memory& memory) : assembly(memory) {}
    Assembly assembly;
    bool whole = false;                      // all is here, and the payload is what its hash says
    std::optional<wire::Head> head;          // all that is left of a record without its body
    std::optional<Notary::Verdict> verdict;  // when its predecessor was here
    Endpoint from;                           // who completed it
    std::uint8_t hops = 0;
    Peer* target = nullptr;                          // who is asked
    bool complete() const { return whole || head; }  // it waits for its turn, or for room in the store
    std::size_t reserved_bytes = 0;
    unsigned bad_bodies = 0;  // complete, with a wrong hash
    Instant not_before{};     // then it is asked for again
  };
  using Fetches = std::pmr::map<RecordId, Fetch>;

  std::size_t window(const Peer& peer, std::uint8_t lane) const;
  std::uint32_t held(const LogId& log) const;
  void note_need(const RecordId& id, const Fetch& fetch);
  // fetcher.cpp: asking
  void ask(Instant now, Peer& peer, const RecordId& id, Fetch& fetch);
  void ask_run(Instant now, Peer& peer, const RecordId& id, Fetch& fetch, std::uint32_t first, std::uint32_t end);
  Peer* choose(Instant now, const RecordId& id, Peers& peers, const Peer* other_than = nullptr) const;
  void ask_missing(Instant now, std::uint8_t lane, Peers& peers);
  void open_more(Instant now, std::uint8_t lane, Peers& peers);
  bool open(Instant now, const RecordId& id, Peers& peers);
  // fetcher_answers.cpp
  bool takes_unasked(const Peer& from, const wire::Data& data) const;
  bool repeats_push(const wire::Data& data) const;
  void accept_pushed(Instant now, Peer& from, const wire::Data& data);
  bool learn(Peer& from, const wire::Data& data, Fetch& fetch);
  bool reserve(const RecordId& id, Fetch& fetch, std::uint32_t bytes);
  bool make_room(const RecordId& id, std::size_t bytes);
  void remember_size(const RecordId& id, std::uint32_t bytes);
  void settle(Instant now, Peer& from, const RecordId& id, Fetch& fetch);
  void completed(Instant now, const Peer& from, std::uint8_t hops, LogId log, Fetch& fetch);
  static Record record_of(const RecordId& id, const Fetch& fetch);
  void distrust(Instant now, Fetch& fetch);
  bool is_replaced(const Record& record, const std::optional<SignedHead>& by) const;
  Notary::Verdict verdict_of(const Record& record, const std::optional<SignedHead>& by) const;
  bool spoilt(Instant now, const RecordId& id, Fetch& fetch, Refusal reason);
  bool is_authors_next(Instant now, const Record& record, Fetch& fetch);
  Status store(Record record, const Hash& hash, std::uint8_t hops);
  void store_in_order(Instant now, const LogId& log);
  bool refused(const LogId& log);
  // fetcher_losses.cpp
  void lose(const AskLedger::Fragments& fragments);
  void retarget(Instant now, Peer& silent, Peers& peers);
  void leave_the_silent(Instant now, Peers& peers);
  void release(const RecordId& id, Fetch& fetch);  // takes back all that was asked
  void restart(const RecordId& id, Fetch& fetch);  // forgets all that came
  void close(const RecordId& id);                  // as if never opened; it will be opened again

  Memory* memory_;
  Limits limits_;
  LogStore& store_;
  HeldLogs& here_;
  Notary& notary_;
  Counters& counters_;
  Judge judge_;
  KeepingOf keeping_;
  Fetches fetches_;
  std::array<std::pmr::set<RecordId>, kLaneCount> needs_;                // with missing fragments
  std::array<std::pmr::map<LogId, std::uint32_t>, kLaneCount> lacking_;  // log -> next record to open
  std::array<std::uint32_t, kLaneCount> guess_{1, 1, 4, 8, 8};           // fragments of the next record
  struct Blocked {
    Instant again;
    std::string why;
  };
  std::pmr::map<LogId, Blocked> blocked_;         // the store had no room; try again then
  Instant wake_ = Instant::max();                 // a fetch is asked for again then
  std::pmr::map<RecordId, std::uint32_t> sizes_;  // of records whose fetch was closed for want of room
  AllStored stored_, stored_taken_;
  AllSpoilt spoilt_, spoilt_taken_;
  std::size_t used_bytes_ = 0;
  bool offered_ = false;         // since the last plan
  std::size_t no_room_for_ = 0;  // looked for in vain since the last plan: so many bytes, and more
  std::uint32_t next_serial_ = 1;
};

}  // namespace onemap::comms
