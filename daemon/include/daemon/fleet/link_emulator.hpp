#pragma once
#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

#include "daemon/fleet/link_graph.hpp"
#include "hal/base/result.hpp"
#include "hal/base/time.hpp"

namespace onemap::daemon {

struct LinkFaults {
  double loss = 0;   // 0..1, of the datagrams of each direction
  Duration delay{};  // of each direction
  std::uint64_t seed = 1;
};

struct LinkCounters {
  std::uint64_t forwarded = 0, lost = 0, without_receiver = 0;
};

// Radio links between processes of one machine, in user space. A link is two UDP sockets on 127.0.0.1, one towards each
// of its robots: a robot sends to its own end, as if that were the neighbour, and hears the neighbour from there. Who a
// robot is, an end learns from the last datagram it got, so robots may listen at any port. Seeded loss and fixed delay.
class LinkEmulator {
 public:
  static Result<std::unique_ptr<LinkEmulator>> open(const std::vector<FleetLink>& links, const LinkFaults& faults);
  ~LinkEmulator();
  LinkEmulator(const LinkEmulator&) = delete;
  LinkEmulator& operator=(const LinkEmulator&) = delete;

  // The port at 127.0.0.1 to which the robot sends on this link; the robot is one of the link's two.
  std::uint16_t port(std::size_t link, std::size_t robot) const;
  void start();
  void stop();
  LinkCounters counters() const { return {forwarded_, lost_, without_receiver_}; }

 private:
  struct End;
  struct Late;
  explicit LinkEmulator(const LinkFaults& faults);
  void run();
  void receive(std::size_t end);
  void deliver_due(Instant now);
  void forward(const Late& datagram);
  const LinkFaults faults_;
  std::vector<FleetLink> links_;
  std::vector<End> ends_;   // 2 * link: towards the link's first robot; 2 * link + 1: its second
  std::vector<Late> late_;  // a heap by due time, then by arrival
  std::uint64_t arrivals_ = 0;
  std::atomic<std::uint64_t> forwarded_ = 0, lost_ = 0, without_receiver_ = 0;
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

}  // namespace onemap::daemon
