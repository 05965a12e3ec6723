#pragma once
#include <map>
#include <memory_resource>
#include <span>

#include "hal/base/ids.hpp"

namespace onemap::comms {

// Two amounts that robots pass on together; the quotient of their sums over the team is what they agree on. A mean: y
// is the value, z is 1 everywhere. A sum: z is 1 at one robot and 0 elsewhere.
struct Mass {
  double y = 0.0, z = 0.0;
  bool operator==(const Mass&) const = default;
  Mass& operator+=(const Mass& other) { return y += other.y, z += other.z, *this; }
  Mass& operator-=(const Mass& other) { return y -= other.y, z -= other.z, *this; }
  friend Mass operator*(double share, const Mass& mass) { return {share * mass.y, share * mass.z}; }
};

// One robot's side of ratio consensus with running sums (Vaidya, Hadjicostis, Domínguez-García: "Robust average
// consensus over packet dropping links", 2011), with Metropolis weights. A message is not what was given but all that
// was given so far, so losing, repeating and reordering messages loses nothing: a later one makes up for it.
class RunningSums {
 public:
  // Greater amounts, and what is no number, are nobody's honest message.
  static constexpr double kMost = 1e15;

  explicit RunningSums(Mass own, std::pmr::memory_resource& memory = *std::pmr::new_delete_resource())
      : held_(own), given_(&memory), taken_(&memory) {}
  void begin(Mass own);  // nothing was given or taken

  struct Link {
    RobotId to;
    double weight = 0.0;  // all together less than 1
  };
  void round(std::span<const Link> links);  // gives each neighbour its share
  // All that this neighbour was given since the beginning: what it is told, as often as one likes.
  Mass given_to(const RobotId& robot) const;
  // It was told, in the order in which it was said. False: no number, or too great; nothing changed.
  bool heard(const RobotId& from, const Mass& given_so_far);

  const Mass& held() const { return held_; }
  // What the team agrees on, as far as it is known here; `otherwise` while nothing is.
  double value(double otherwise) const;

 private:
  Mass held_;
  std::pmr::map<RobotId, Mass> given_, taken_;
};

}  // namespace onemap::comms
