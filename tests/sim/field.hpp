#pragma once
#include <cstddef>
#include <vector>

#include "sim/sim_net.hpp"

namespace onemap::comms::sim {

// Robots that drive about in a square of side 1 and hear whom they are near to: the disk model.
class Field {
 public:
  struct Model {
    double reach = 0.0;  // as a share of the side; 0: nobody moves, and the graph is what it is
    double speed = 0.0;  // of each robot, a second
  };
  Field(Model model, std::size_t robots, Random& random);
  void drive(Duration time);
  void apply(SimNet& net) const;  // who is near hears each other, and nobody else
  // Stands still, and everybody reaches everybody over some ways: the reach grows until that is so.
  void gather();
  std::vector<Edge> edges() const;

 private:
  struct Place {
    double x, y, dx, dy;
  };
  bool near(const Place& a, const Place& b) const;
  Model model_;
  std::vector<Place> places_;
};

}  // namespace onemap::comms::sim
