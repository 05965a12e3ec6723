#include "comms/consensus/running_sums.hpp"

#include <cmath>

namespace onemap::comms {

void RunningSums::begin(Mass own) {
  held_ = own;
  given_.clear();
  taken_.clear();
}

void RunningSums::round(std::span<const Link> links) {
  const Mass before = held_;
  for (const Link& link : links) {
    const Mass share = link.weight * before;
    given_[link.to] += share;
    held_ -= share;
  }
}

Mass RunningSums::given_to(const RobotId& robot) const {
  const auto at = given_.find(robot);
  return at == given_.end() ? Mass{} : at->second;
}

bool RunningSums::heard(const RobotId& from, const Mass& given_so_far) {
  const auto fine = [](double amount) { return std::isfinite(amount) && std::abs(amount) <= kMost; };
  if (!fine(given_so_far.y) || !fine(given_so_far.z)) return false;
  Mass& taken = taken_[from];
  held_ += given_so_far;
  held_ -= taken;
  taken = given_so_far;
  return true;
}

double RunningSums::value(double otherwise) const { return held_.z > 1e-12 ? held_.y / held_.z : otherwise; }

}  // namespace onemap::comms
