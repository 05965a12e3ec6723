#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "comms/consensus/running_sums.hpp"
#include "comms/consensus/scalars.hpp"
#include "comms/wire/frames.hpp"
#include "hal/base/ids.hpp"
#include "hal/base/time.hpp"
#include "memory/memory.hpp"

namespace onemap::comms {

// One robot's part in the team's talks about its scalars. A round of talks begins when the team changes, or what a
// robot brings; everybody who hears of a later round joins it with what it has, and the earlier one is over: so nothing
// of who has gone is left in the sums. Within a round masses go about as running sums, twice a second until
// nothing changes any more. A pure function of what it is told.
class Talks {
 public:
  Talks(const RobotId& self, std::uint64_t incarnation, Memory& memory = heap());

  void bring(Instant now, Scalar which, double own);  // finite; team_size needs nothing
  void team_changed(Instant now);                     // who is a neighbour; not before the first of them

  struct Near {
    RobotId robot;
    std::size_t neighbours = 1;  // that it has itself
  };
  bool due(Instant now) const { return next() <= now; }
  Instant next() const;
  // One exchange, if one is due: then every neighbour is to be told.
  bool exchange(Instant now, std::span<const Near> near);
  // All that this neighbour needs to know, as often as one likes. How the link is, and whether amounts go with it, is
  // the node's to say.
  void tell(Instant now, const RobotId& to, wire::Mass& mass) const;
  // False: no honest robot says that.
  bool heard(Instant now, const RobotId& from, const wire::Mass& mass, Duration on_its_way);

  ScalarsView view() const;

 private:
  void begin(Instant now, std::uint64_t round, Duration reference);
  Mass own_mass(std::size_t which) const;
  double value(std::size_t which) const;
  bool changed_since();
  Memory* memory_;
  std::uint64_t mark_;       // of this robot in the rounds that it begins
  std::uint64_t round_ = 0;  // upper 40 bits count, lower 24 say who began
  bool began_here_ = false;
  Instant begun_{};
  Duration reference_{};  // the beginner's wall clock is ahead of our monotonic one by this
  std::array<double, kScalars> brought_{}, in_use_{};
  std::array<bool, kScalars> has_{};
  std::array<RunningSums, kScalars> sums_;
  std::array<double, kScalars> last_{};
  unsigned quiet_ = 0;  // exchanges in a row that changed nothing
  std::uint64_t exchanges_ = 0;
  std::optional<Instant> begin_at_;  // a round of our own
  Instant next_exchange_ = Instant::max();
};

}  // namespace onemap::comms
