#pragma once
#include <memory>
#include <string>

#include "hal/base/result.hpp"
#include "render/camera.hpp"
#include "render/image.hpp"
#include "render/scene.hpp"

namespace onemap::render {

struct Style {
  int width_px = 1280, height_px = 720;
  Color background{198, 203, 209};
  bool points_only = false;       // draw a mesh's vertices as points
  bool both_sides = false;        // draw surfaces seen from behind too; off: one looks through walls into the room
  float shading = 0.35f;          // 0: the photograph's colours as they are, 1: full light and shadow
  float depth_cues = 0.6f;        // darker hollows, lines at edges: 0: none, 1: strong
  float point_size_m = 0;         // side; 0: from the cloud's own spacing, so that it makes a closed surface
  float path_width_px = 2.6f;     // trajectories; 0: none
  float marker_width_px = 1.25f;  // edges of the camera pyramids
  float marker_size_m = 0;        // depth of a camera pyramid; 0: by the distance between them
};

// Draws scenes. One thread at a time; several renderers in a process are independent.
class Renderer {
 public:
  virtual ~Renderer() = default;
  // Errors: a size that the device does not support, no memory left, a lost device.
  virtual Result<Image> draw(const Scene& scene, const Camera& camera, const Style& style) = 0;
  // What draws, for logs: "llvmpipe (LLVM 15.0.6, 256 bits), OpenGL ES 3.2 Mesa 22.3.6".
  virtual std::string description() const = 0;
};

// Off-screen through EGL and OpenGL ES 3 without a display: the surfaceless platform, or else a device. The error says
// which step failed when the machine has no such driver.
Result<std::unique_ptr<Renderer>> open_egl_renderer();

}  // namespace onemap::render
