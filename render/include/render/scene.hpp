#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mapping/geometry.hpp"
#include "mapping/mesh.hpp"

namespace onemap::render {

using Color = std::array<std::uint8_t, 3>;

// The colour of robot n (0, 1, ...): red, blue, green, yellow, magenta as in the paper's figure 11, then more.
Color robot_color(std::size_t n);

// The colours of a team, one a name, in the order of the names given: a name that ends in a number n (robot2, r2) has
// robot_color(n - 1), another one a colour by its letters; where that is taken by a name that sorts earlier, the next
// free one while there are such. So a robot that stands alone in a picture has its team's colour, as long as the team
// has no two robots of one number.
std::vector<Color> robot_colors(const std::vector<std::string>& names);

// One robot's way through the scene, in the scene's frame.
struct RobotPath {
  std::string name;
  Color color{};
  std::vector<mapping::Pose> poses;           // T_scene_camera of every tracked frame: the line
  std::vector<mapping::Pose> keyframe_poses;  // drawn as camera triangles (the paper, figures 10 and 11)
};

// What a picture or a model shows. Frame: the map's, metres, y down in the reference camera's optical frame.
struct Scene {
  std::string title;             // name of the root node in a model
  mapping::TriangleMesh mesh;    // drawn if it has triangles,
  mapping::ColoredCloud points;  // else these
  std::vector<RobotPath> robots;
  std::optional<mapping::Vector3f> up;  // where the map says it; else up_of() finds it
};

}  // namespace onemap::render
