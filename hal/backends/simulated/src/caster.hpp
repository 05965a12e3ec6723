#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "arithmetic.hpp"
#include "hal/frame.hpp"
#include "scene.hpp"

namespace onemap::hal::simulated {

// What one image row sees.
struct Row {
  explicit Row(int width)
      : inverse_depth(static_cast<std::size_t>(width)),
        rgb(3 * static_cast<std::size_t>(width)),
        weak(static_cast<std::size_t>(width)) {}
  std::vector<float> inverse_depth;  // 1/m along the optical axis; 0: nothing
  std::vector<std::uint8_t> rgb;     // without blur and noise
  std::vector<std::uint8_t> weak;    // 1 where a depth camera gets no answer: grazing or dark
};

// Casts one ray a pixel, row by row, exactly: along a row a plane's inverse depth, and its texture coordinates times
// inverse depth, are straight lines, so what a patch covers is one span whose ends are solved for; tubes and balls are
// solved pixel by pixel within their bounds. Allocates in the constructor only.
class Caster {
 public:
  Caster(const Scene& scene, const Intrinsics& intrinsics);
  void start(const CameraPose& pose);
  void cast(int y, Row& row);

 private:
  // dx*x + dy*y + c at pixel (x, y).
  struct Linear {
    double dx = 0, dy = 0, c = 0;
    double at(double x, double y) const { return dx * x + dy * y + c; }
  };
  struct Bounds {
    int x0 = 0, y0 = 0, x1 = -1, y1 = -1;  // inclusive
    bool empty() const { return x0 > x1 || y0 > y1; }
  };
  struct SeenPatch {
    const Patch* patch;
    const Texture* texture;
    Bounds bounds;
    Linear w, u, v;     // inverse depth; texture coordinates in metres, times inverse depth
    double distance_m;  // of the plane from the camera
    int level8;         // pyramid level at 1 m depth, in 1/256
  };
  struct SeenCurved {
    const Curved* curved;
    const Texture* texture;
    Bounds bounds;
    Vec3 centre, axis;  // in the camera's frame
    double c;           // the quadratic's constant term
    int level8;
  };

  Linear along(Vec3 direction) const;
  Vec3 to_camera(Vec3 direction) const;
  Bounds bounds_of(const std::array<Vec3, 8>& corners, std::size_t count) const;
  void see_patch(const Patch& patch);
  void see_curved(const Curved& curved);
  void draw_patch(const SeenPatch& seen, int id, int y, float* w);
  void draw_curved(const SeenCurved& seen, int id, int y, float* w);
  void shade_patch(const SeenPatch& seen, int y, int x0, int x1, Row& row) const;
  void shade_curved(const SeenCurved& seen, int y, int x0, int x1, Row& row) const;

  const Scene& scene_;
  const Intrinsics k_;
  CameraPose pose_;
  std::vector<SeenPatch> patches_;
  std::vector<SeenCurved> curved_;
  std::vector<std::int32_t> ids_;  // of the current row: patches first, then curved
};

}  // namespace onemap::hal::simulated
