#pragma once
#include "render/camera.hpp"
#include "render/image.hpp"
#include "render/renderer.hpp"
#include "render/scene.hpp"

namespace onemap::render {

// Draws into a picture of the scene what makes it readable: the robots' names in their colours, a bar as long as a
// metre at the middle of what is shown, and the axes of the scene's upright frame. On a plan: a grid of metres and the
// bar.
void draw_legend(Image& image, const Scene& scene, const Camera& camera);

// The bar alone.
void draw_bar(Image& image, const Camera& camera);

// A picture with its legend, or without (plain).
Result<Image> take_picture(Renderer& renderer, const Scene& scene, const Camera& camera, const Style& style,
                           bool plain = false);

}  // namespace onemap::render
