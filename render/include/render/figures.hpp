#pragma once
#include <span>
#include <string>
#include <vector>

#include "hal/base/result.hpp"
#include "render/camera.hpp"
#include "render/renderer.hpp"
#include "render/scene.hpp"

namespace onemap::render {

// The paper's figure 10: the maps of a team beside each other, each with its title and the number of its triangles, in
// one picture of the style's size, in as many rows as make them largest.
// whole: the map of all of them, from whose side they are then seen (cameras_beside()); nullptr: each from its own.
// plain: without a bar as long as a metre in each. No map: an error.
Result<Image> draw_side_by_side(Renderer& renderer, std::span<const Scene> maps, const Style& style,
                                const Scene* whole = nullptr, bool plain = false);

// How wide each of these maps' pictures is, beside its height, in rows of so many whose pictures are `aspect` on the
// mean: where they are seen at one scale a wide map has more of its row.
std::vector<float> aspects_beside(std::span<const Scene> maps, float aspect, std::size_t columns, const Scene* whole);

// From where each of these maps is seen, in its own frame, in pictures of these widths / heights. Those of robots that
// the whole map has, too, are seen in one direction, that in which `fit` shows the whole at 16 : 9, and at one scale,
// so that one can be held against the next; the others as `fit` does.
std::vector<Camera> cameras_beside(std::span<const Scene> maps, std::span<const float> aspects, const Scene* whole);

// Who is in a team, and who verified what of whom.
struct TeamPicture {
  struct Robot {
    std::string name;
    Color color{};
    std::uint64_t keyframes = 0;
    bool in_map = false;
  };
  struct Link {
    std::size_t a = 0, b = 0;  // of robots
    bool accepted = false;
    std::uint64_t inliers = 0;  // matched features that agree,
    std::uint64_t pairs = 0;    // of so many pairs of clouds
    std::string reason;         // of a refused one: "too few matches"
  };
  std::vector<Robot> robots;
  std::vector<Link> links;
  std::string reference;  // the robot in whose frame the map is; empty: none yet
};

// The team as a picture: robots on a circle, links between them (accepted ones as thick as they have inliers, refused
// ones broken), beside it the same as a list in words. Links of robots that are not there are left out.
Image draw_team(const TeamPicture& team, int width_px = 1280, int height_px = 720);

}  // namespace onemap::render
