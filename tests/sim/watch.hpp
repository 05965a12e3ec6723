#pragma once
#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "comms/wire.hpp"
#include "sim/sim_net.hpp"

namespace onemap::comms::sim {

// The invariants that hold at every moment whatever happens, each with its number of looks, so that a test can see that
// it was looked at at all. The first that breaks is kept in words; who runs the net asks for it.
class Watch final : public Witness {
 public:
  explicit Watch(SimNet& net) : net_(net) { net.witness = this; }
  ~Watch() override { net_.witness = nullptr; }
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

  bool broken() const { return !what_.empty(); }
  const std::string& what() const { return what_; }
  std::uint64_t looks() const { return looks_; }
  std::uint64_t set_hash(std::size_t robot) const { return robots_[robot].set_hash; }
  // Its power came back: what it wrote, and said was kept, is on its disk.
  void came_back(std::size_t robot);
  void look_at_bodies(std::size_t robot);  // of all that its store holds
  void wiped(std::size_t robot) {
    std::uint64_t& below = seen(robot).wiped_below;
    below = std::max(below, net_[robot].config.incarnation + 1);
  }

  void sent(std::size_t from, const OutgoingDatagram& datagram) override;
  void arrives(std::size_t to, const Endpoint& from, std::span<const std::uint8_t> bytes) override;
  void applied(std::size_t robot, const Record& record) override;
  void appended(std::size_t robot, const Record& record) override;
  void moved(std::size_t robot) override;
  void began(std::size_t robot) override;

 private:
  struct Stranger {
    bool proved = false;
    std::uint64_t in = 0, out = 0;
    std::uint32_t credit = 0;                                 // the greatest that it gave itself
    std::set<std::pair<std::uint64_t, std::uint32_t>> wants;  // datagrams that asked, by life and counter
  };
  using Fragment = std::pair<RecordId, std::uint32_t>;
  struct Owes {
    std::uint32_t asked = 0, sent = 0;
  };
  struct Number {  // of a datagram
    std::uint32_t session = 0;
    std::uint64_t counter = 0;
    bool operator==(const Number&) const = default;
    struct Hash {
      std::size_t operator()(const Number& n) const { return splitmix64(n.counter ^ std::uint64_t{n.session} << 32); }
    };
  };
  struct Seen {
    std::uint64_t wiped_below = 0;  // lives whose records may be gone
    VersionVector frontier;
    std::uint64_t digest = 0;
    std::map<LogId, std::uint32_t> next;  // record to be applied
    std::uint64_t set_hash = 0;
    std::uint64_t moves = 0, changes = 0;
    std::map<Endpoint, Stranger> others;
    std::map<std::pair<Endpoint, Fragment>, Owes> owed;
    std::unordered_set<Number, Number::Hash> numbers;  // that were used
  };
  void broke(std::size_t robot, const std::string& what);
  Seen& seen(std::size_t robot);
  void look_at_frontier(std::size_t robot, Seen& seen);
  void look_at_flights(std::size_t robot, const Seen& seen);
  bool lives_there(std::size_t robot, const Endpoint& at) const;
  void look_at_seal(std::size_t from, Seen& here, const OutgoingDatagram& datagram);
  void note_wants(Seen& seen, Stranger& other, const Endpoint& from);

  SimNet& net_;
  std::string what_;
  std::uint64_t looks_ = 0;
  std::vector<Seen> robots_;
  std::map<RecordId, std::uint64_t> written_;  // by honest authors: what it was
  std::set<RecordId> told_, promised_;         // of these: given out by their authors; and their disks did work then
  std::unordered_map<std::uint64_t, std::uint64_t> sets_;  // digest of a frontier -> the set that it means
  wire::Decoder decoder_;
};

}  // namespace onemap::comms::sim
