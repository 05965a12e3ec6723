// onemap-view: a saved map to a picture or to another model format, without a display.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "daemon/command_line.hpp"
#include "daemon/saved_map.hpp"
#include "hal/base/text.hpp"
#include "render/camera.hpp"
#include "render/file.hpp"
#include "render/gltf_writer.hpp"
#include "render/ply_reader.hpp"
#include "render/ply_writer.hpp"
#include "render/png_writer.hpp"
#include "render/renderer.hpp"

namespace {

using namespace onemap;
using daemon::Ending;
using daemon::Exit;

constexpr const char* kProgram = "onemap-view";
constexpr int kMaxSide_px = 16384;

struct Options {
  std::string map, png, glb, ply;
  std::string size = "1280x720", view = "fit";
  std::vector<float> eye, target;
  bool points = false, mesh = false;
  render::Style style;
};

void declare(CLI::App& app, Options& o) {
  app.add_option("MAP", o.map, "the map: a .ply, .glb or .omap that onemap wrote")->required();
  app.add_option("--png", o.png, "write a picture")->group("Output (at least one)")->type_name("FILE");
  app.add_option("--glb", o.glb, "write a glTF 2.0 model: map, trajectories and cameras as named nodes")
      ->group("Output (at least one)")
      ->type_name("FILE");
  app.add_option("--ply", o.ply, "write the map as binary PLY")->group("Output (at least one)")->type_name("FILE");
  auto* points = app.add_flag("--points", o.points, "only the points of a mesh")->group("What");
  app.add_flag("--mesh", o.mesh, "triangles; an error if the map has none")->group("What")->excludes(points);
  app.add_option("--view", o.view,
                 "fit: the room from behind and above the cameras; top: from above; front: what the first camera "
                 "saw; follow: over the shoulder of the last camera")
      ->group("Picture")
      ->check(CLI::IsMember({"fit", "top", "front", "follow"}))
      ->capture_default_str();
  auto* eye =
      app.add_option("--eye", o.eye, "look from here, X,Y,Z in metres; x right, y down, z ahead of the first camera")
          ->group("Picture")
          ->delimiter(',')
          ->expected(3)
          ->type_name("X,Y,Z");
  app.add_option("--target", o.target, "look at this point (with --eye; default: the map's origin)")
      ->group("Picture")
      ->delimiter(',')
      ->expected(3)
      ->type_name("X,Y,Z")
      ->needs(eye);
  app.add_option("--size", o.size, "width and height in pixels")
      ->group("Picture")
      ->type_name("WxH")
      ->capture_default_str();
  app.add_option("--point-size", o.style.point_size_m, "diameter of a point in metres (default: by their spacing)")
      ->group("Picture")
      ->check(CLI::PositiveNumber);
  app.add_option("--shading", o.style.shading, "0: the photographs' colours, 1: strong light and shadow")
      ->group("Picture")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  app.add_flag("--both-sides", o.style.both_sides,
               "draw surfaces from behind too (else one looks through walls into the room)")
      ->group("Picture");
  app.footer(
      "Examples:\n"
      "  onemap-view global.glb --png global.png\n"
      "  onemap-view global.glb --png plan.png --view top --size 1920x1080\n"
      "  onemap-view local.ply --png desk.png --eye 0,-0.5,-1 --target 0,0,1.5\n"
      "  onemap-view global.glb --ply global.ply --points\n"
      "Exit status: 0 done, 1 a file or the renderer failed, 2 wrong options.");
}

bool ends_with(const std::string& text, const std::string& ending) {
  return text.size() >= ending.size() && text.compare(text.size() - ending.size(), ending.size(), ending) == 0;
}

// What CLI11's ranges let through: not a number, and infinitely far.
std::optional<std::string> check_numbers(const Options& o) {
  const auto finite = [](const std::vector<float>& v) {
    return std::all_of(v.begin(), v.end(), [](float x) { return std::isfinite(x); });
  };
  if (!finite(o.eye)) return "--eye: expected three finite numbers";
  if (!finite(o.target)) return "--target: expected three finite numbers";
  if (!finite({o.style.shading})) return "--shading: expected a number from 0 to 1";
  if (!finite({o.style.point_size_m})) return "--point-size: expected a finite number of metres";
  return std::nullopt;
}

std::optional<std::string> parse_size(const std::string& text, render::Style& style) {
  int used = 0;
  if (std::sscanf(text.c_str(), "%5dx%5d%n", &style.width_px, &style.height_px, &used) == 2 &&  // NOLINT(cert-err34-c)
      static_cast<std::size_t>(used) == text.size() && std::min(style.width_px, style.height_px) > 0 &&
      std::max(style.width_px, style.height_px) <= kMaxSide_px)
    return std::nullopt;
  return fmt::format("--size: {} is not WIDTHxHEIGHT, for example 1280x720, of at most {} pixels each", text,
                     kMaxSide_px);
}

Result<render::Scene> read_map(const std::string& path) {
  if (ends_with(path, ".glb")) return render::read_glb(path);
  if (ends_with(path, ".omap")) {
    const auto bytes = render::read_file(path);
    if (!bytes) return bytes.error();
    return daemon::load_map(path, *bytes);
  }
  if (!ends_with(path, ".ply")) return Error{path, "neither a .ply, a .glb nor an .omap"};
  auto mesh = render::read_ply(path);
  if (!mesh) return mesh.error();
  render::Scene scene;
  scene.title = "map";
  scene.mesh = std::move(*mesh);
  return scene;
}

// --points and --mesh; a mesh without triangles is a cloud.
Status choose_primitives(const Options& o, render::Scene& scene) {
  if (scene.mesh.triangles.empty() || o.points) {
    if (o.mesh) return Error{o.map, "has no triangles (--mesh)"};
    auto& mesh = scene.mesh;
    if (!mesh.vertices.empty())
      scene.points = {std::move(mesh.vertices), std::move(mesh.normals), std::move(mesh.colors)};
    mesh = {};
  }
  return success();
}

Status write_picture(const Options& o, const render::Scene& scene) {
  auto renderer = render::open_egl_renderer();
  if (!renderer) return renderer.error();
  const auto vector = [](const std::vector<float>& v) {
    return v.empty() ? glm::vec3(0) : glm::vec3(v[0], v[1], v[2]);
  };
  const float aspect = static_cast<float>(o.style.width_px) / static_cast<float>(o.style.height_px);
  const render::Camera camera =
      o.eye.empty() ? make_camera(scene, render::view_from_name(o.view).value_or(render::View::fit), aspect)
                    : make_camera(scene, vector(o.eye), vector(o.target));
  auto image = (*renderer)->draw(scene, camera, o.style);
  if (!image) return image.error();
  return render::write_png(o.png, *image);
}

Status write_map_ply(const Options& o, const render::Scene& scene) {
  return scene.mesh.triangles.empty() ? render::write_ply(o.ply, scene.points) : render::write_ply(o.ply, scene.mesh);
}

Status run(const Options& o) {
  auto scene = read_map(o.map);
  if (!scene) return scene.error();
  if (auto chosen = choose_primitives(o, *scene); !chosen) return chosen;
  const auto& mesh = scene->mesh;
  fmt::print("{}: {} points, {} triangles, {} robots\n", printable(o.map),
             mesh.vertices.size() + scene->points.points.size(), mesh.triangles.size(), scene->robots.size());
  if (!o.png.empty()) {
    if (auto done = write_picture(o, *scene); !done) return done;
    fmt::print("{}\n", printable(o.png));
  }
  if (!o.glb.empty()) {
    if (auto done = render::write_glb(o.glb, *scene); !done) return done;
    fmt::print("{}\n", printable(o.glb));
  }
  if (!o.ply.empty()) {
    if (auto done = write_map_ply(o, *scene); !done) return done;
    fmt::print("{}\n", printable(o.ply));
  }
  return success();
}

Ending view(const std::vector<std::string>& arguments) {
  CLI::App app{"Draws a saved map off-screen, or converts it.", kProgram};
  Options options;
  declare(app, options);
  if (auto ending = daemon::parse_command_line(app, arguments)) return *ending;
  std::optional<std::string> wrong = parse_size(options.size, options.style);
  if (!wrong) wrong = check_numbers(options);
  if (options.png.empty() && options.glb.empty() && options.ply.empty())
    wrong = "nothing to do: give --png, --glb or --ply";
  if (wrong) return {Exit::usage, daemon::complaint(kProgram, *wrong)};
  const Status done = run(options);
  return done ? Ending{} : Ending{Exit::failed, daemon::complaint(kProgram, done.error().text())};
}

}  // namespace

int main(int argc, char** argv) {
  return daemon::run_program(kProgram, argc, argv, [](const auto& arguments) { return daemon::end(view(arguments)); });
}
