// What a picture of 1280 x 720 costs, in processor time of this process:
//   LP_NUM_THREADS=1 bench_picture MAP.glb     (LP_NUM_THREADS: llvmpipe on one core)
// The median of ten of each part, after one that compiles the driver's programs.
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <vector>

#include "render/gltf_writer.hpp"
#include "render/legend.hpp"
#include "render/png_writer.hpp"

namespace {

using namespace onemap::render;

double processor_ms() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
}

struct Costs {
  std::vector<double> viewpoint, picture, png;
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

bool draw(const Scene& scene, Renderer& renderer, Costs& costs) {
  const Style style;
  const double start = processor_ms();
  const Camera camera = make_camera(scene, View::fit, 1280.0f / 720);
  const double seen = processor_ms();
  const auto image = take_picture(renderer, scene, camera, style);
  const double drawn = processor_ms();
  if (!image || !encode_png(*image)) return false;
  costs.viewpoint.push_back(seen - start);
  costs.picture.push_back(drawn - seen);
  costs.png.push_back(processor_ms() - drawn);
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return fmt::print(stderr, "usage: bench_picture MAP.glb\n"), 2;
  const auto scene = read_glb(argv[1]);
  const auto renderer = open_egl_renderer();
  if (!scene || !renderer) return fmt::print(stderr, "{}\n", (scene ? renderer.error() : scene.error()).text()), 1;
  Costs costs, first;
  if (!draw(*scene, **renderer, first)) return 1;
  for (int i = 0; i < 10; ++i)
    if (!draw(*scene, **renderer, costs)) return 1;
  fmt::print("{}: {} triangles\n", (*renderer)->description(), scene->mesh.triangles.size());
  fmt::print("viewpoint {:.0f} ms, picture {:.0f} ms (the first {:.0f}), PNG {:.0f} ms\n", median(costs.viewpoint),
             median(costs.picture), first.picture[0], median(costs.png));
}
