#include "render/map_server_writer.hpp"

#include <fmt/format.h>

#include <vector>

#include "hal/base/file.hpp"

namespace onemap::render {
namespace {

using mapping::FloorPlan;
using mapping::Space;

std::uint8_t grey(Space space) { return space == Space::occupied ? 0 : space == Space::empty ? 254 : 205; }

std::vector<std::uint8_t> pgm(const FloorPlan& plan) {
  const std::string head =
      fmt::format("P5\n# onemap, {:.3f} m a pixel\n{} {}\n255\n", plan.cell_m, plan.width, plan.height);
  std::vector<std::uint8_t> bytes(head.begin(), head.end());
  bytes.reserve(head.size() + plan.cells.size());
  for (int y = plan.height - 1; y >= 0; --y)
    for (int x = 0; x < plan.width; ++x) bytes.push_back(grey(plan.at(x, y)));
  return bytes;
}

// 205 is an occupancy of 0.19608: with 0.196, and not with a rounder number, it is unknown.
std::string yaml(const std::string& image, const FloorPlan& plan, const mapping::Pose& T) {
  const auto q = mapping::to_quaternion_wxyz(T.R);
  return fmt::format(
      "# onemap: z is up, the floor is z = 0. A point of the map's frame is T_plan_map * point;\n"
      "# T_plan_map (tx ty tz qx qy qz qw): {:.6f} {:.6f} {:.6f} {:.9f} {:.9f} {:.9f} {:.9f}\n"
      "image: {}\n"
      "resolution: {:.6f}\n"
      "origin: [{:.6f}, {:.6f}, 0.0]\n"
      "negate: 0\n"
      "occupied_thresh: 0.65\n"
      "free_thresh: 0.196\n",
      T.t.x(), T.t.y(), T.t.z(), q[1], q[2], q[3], q[0], image, plan.cell_m, plan.origin_x_m, plan.origin_y_m);
}

}  // namespace

Status write_map_server(const std::string& stem, const FloorPlan& plan, const mapping::Pose& T_plan_map) {
  if (auto written = write_file(stem + ".pgm", pgm(plan)); !written) return written;
  const std::string image = stem.substr(stem.find_last_of('/') + 1) + ".pgm";
  return write_text_file(stem + ".yaml", yaml(image, plan, T_plan_map));
}

}  // namespace onemap::render
