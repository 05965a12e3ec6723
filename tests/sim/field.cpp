#include "sim/field.hpp"

#include <algorithm>

namespace onemap::comms::sim {

namespace {
void bounce(double& at, double& step) {
  if (at < 0.0) at = -at, step = -step;
  if (at > 1.0) at = 2.0 - at, step = -step;
}
}  // namespace

Field::Field(Model model, std::size_t robots, Random& random) : model_(model) {
  for (std::size_t i = 0; i < robots; ++i)
    places_.push_back({random.unit(), random.unit(), random.uniform(-1, 1), random.uniform(-1, 1)});
}

void Field::drive(Duration time) {
  const double way = model_.speed * to_seconds(time);
  for (Place& place : places_) {
    place.x += way * place.dx;
    place.y += way * place.dy;
    bounce(place.x, place.dx);
    bounce(place.y, place.dy);
  }
}

bool Field::near(const Place& a, const Place& b) const {
  const double x = a.x - b.x, y = a.y - b.y;
  return x * x + y * y <= model_.reach * model_.reach;
}

std::vector<Edge> Field::edges() const {
  std::vector<Edge> edges;
  for (std::size_t i = 0; i < places_.size(); ++i)
    for (std::size_t j = i + 1; j < places_.size(); ++j)
      if (near(places_[i], places_[j])) edges.emplace_back(i, j);
  return edges;
}

void Field::apply(SimNet& net) const {
  for (std::size_t i = 0; i < places_.size(); ++i)
    for (std::size_t j = i + 1; j < places_.size(); ++j)
      if (near(places_[i], places_[j]))
        net.connect(i, j);
      else
        net.cut(i, j);
}

void Field::gather() {
  const auto parted = [&] {
    const auto way = distances(places_.size(), edges(), 0);
    return std::find(way.begin(), way.end(), -1) != way.end();
  };
  while (parted()) model_.reach *= 1.1;
}

}  // namespace onemap::comms::sim
