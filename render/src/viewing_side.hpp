#pragma once
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <vector>

// From which side a map is looked at.
namespace onemap::render {

// A right-handed frame to look in: x right, y up, z towards the viewer's far side.
struct Frame {
  glm::vec3 right, up, forward;
};

Frame make_frame(const glm::vec3& forward, const glm::vec3& up);
glm::vec3 some_level(const glm::vec3& up);  // any level direction

// A place that must be in view; normal 0: from everywhere.
struct Sample {
  glm::vec3 point, normal;
};

bool faces(const Sample& s, const glm::vec3& towards_eye);

struct Box {
  glm::vec3 low{std::numeric_limits<float>::max()}, high{-std::numeric_limits<float>::max()};
  void add(const glm::vec3& p) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
};

// In the frame's own axes, of what faces the viewer.
Box seen_box(const std::vector<Sample>& samples, const Frame& frame);

// Of directions all around, the one from which most surface is seen in a picture that it fills; rather along walls.
Frame best_side(const std::vector<Sample>& all, const glm::vec3& up, float aspect);

// For a view from above: of the directions within a quarter turn of `away`, that which stands upright in a picture that
// the map fills best. Rooms are then parallel to the picture's rims.
Frame from_above(const std::vector<Sample>& samples, const glm::vec3& up, const glm::vec3& away, float aspect);

}  // namespace onemap::render
