#include "mapping/team/pose_graph_input.hpp"

namespace onemap::mapping {

Matrix6d information_of(double rotation_rad, double translation_m) {
  Vector6d diagonal;
  diagonal.head<3>().setConstant(1 / (rotation_rad * rotation_rad));
  diagonal.tail<3>().setConstant(1 / (translation_m * translation_m));
  return diagonal.asDiagonal();
}

}  // namespace onemap::mapping
