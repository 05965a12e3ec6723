#include "daemon/view/view.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <optional>

#include "daemon/saved_map.hpp"
#include "hal/base/file.hpp"
#include "hal/base/text.hpp"
#include "render/compare.hpp"
#include "render/figures.hpp"
#include "render/follow.hpp"
#include "render/gltf_writer.hpp"
#include "render/legend.hpp"
#include "render/pcd_writer.hpp"
#include "render/ply_reader.hpp"
#include "render/ply_writer.hpp"
#include "render/png_writer.hpp"
#include "render/tidy.hpp"
#include "render/upright.hpp"

namespace onemap::daemon {

namespace {

std::string without_ending(const std::string& file, const std::string& ending) {
  return file.ends_with(ending) ? file.substr(0, file.size() - ending.size()) : file;
}

Result<render::Scene> read_any(const std::string& path) {
  if (path.ends_with(".glb")) return render::read_glb(path);
  if (path.ends_with(".omap")) {
    const auto bytes = read_file(path);
    if (!bytes) return bytes.error();
    return load_map(path, *bytes);
  }
  if (!path.ends_with(".ply")) return Error{path, "neither a .ply, a .glb nor an .omap"};
  auto mesh = render::read_ply(path);
  if (!mesh) return mesh.error();
  render::Scene scene;
  scene.title = path.substr(path.find_last_of('/') + 1);
  scene.mesh = std::move(*mesh);
  return scene;
}

// Reads a map as it is to be drawn: tidied, and with --points or without triangles as a cloud.
Result<render::Scene> read_map(const std::string& path, const ViewOptions& o) {
  auto scene = read_any(path);
  if (!scene) return scene;
  if (!o.keep_crumbs) scene->mesh = render::tidied(std::move(scene->mesh));
  if (!scene->mesh.triangles.empty() && !o.points) return scene;
  if (o.mesh) return Error{path, "has no triangles (--mesh)"};
  auto& mesh = scene->mesh;
  if (!mesh.vertices.empty())
    scene->points = {std::move(mesh.vertices), std::move(mesh.normals), std::move(mesh.colors)};
  mesh = {};
  return scene;
}

float aspect_of(const ViewOptions& o) {
  return static_cast<float>(o.style.width_px) / static_cast<float>(o.style.height_px);
}

render::Camera camera_for(const ViewOptions& o, const render::Scene& scene) {
  const auto vector = [](const std::vector<float>& v) {
    return v.empty() ? glm::vec3(0) : glm::vec3(v[0], v[1], v[2]);
  };
  if (!o.eye.empty()) return make_camera(scene, vector(o.eye), vector(o.target));
  return make_camera(scene, render::view_from_name(o.view).value_or(render::View::fit), aspect_of(o));
}

// Draws scenes into files and finishes each picture in the same way.
class Pictures {
 public:
  Pictures(const ViewOptions& options, render::Renderer& renderer) : options_(options), renderer_(renderer) {}

  Status write(const render::Scene& scene, const render::Camera& camera, const std::string& file) const {
    auto image = render::take_picture(renderer_, scene, camera, options_.style, options_.plain);
    if (!image) return image.error();
    if (!options_.compare.empty()) render::draw_distance_scale(*image, options_.compare_limit_m);
    return render::write_png(file, *image);
  }

  Status turntable(const render::Scene& scene) const {
    const render::Camera first = with_room_to_turn(scene, camera_for(options_, scene), aspect_of(options_));
    const mapping::Vector3f up = render::up_of(scene);
    const auto count = static_cast<std::size_t>(options_.turntable);
    for (std::size_t i = 0; i < count; ++i) {
      render::Camera camera = turned_about_target(first, up, static_cast<float>(i) / static_cast<float>(count));
      if (auto done = write(scene, camera, numbered("", i)); !done) return done;
      say(i + 1, count);
    }
    fmt::print("{} to {}\n", printable(numbered("", 0)), printable(numbered("", count - 1)));
    return success();
  }

  Status views(const render::Scene& scene) const {
    for (const std::string& name : options_.views) {
      const auto view = render::view_from_name(name).value_or(render::View::fit);
      const std::string file = fmt::format("{}_{}.png", without_ending(options_.png, ".png"), name);
      if (auto done = write(scene, make_camera(scene, view, aspect_of(options_)), file); !done) return done;
      fmt::print("{}\n", printable(file));
    }
    return success();
  }

  Status follow_all(const render::Scene& scene) const {
    bool any = false;
    for (const render::RobotPath& robot : scene.robots) {
      const auto poses = render::followed(robot, static_cast<std::size_t>(options_.follow_every));
      const std::string name = scene.robots.size() > 1 ? "_" + robot.name : "";
      for (std::size_t i = 0; i < poses.size(); ++i) {
        const render::Camera camera = render::camera_behind(scene, poses[i]);
        if (auto done = write(scene, camera, numbered(name, i)); !done) return done;
        say(i + 1, poses.size());
      }
      if (!poses.empty())
        fmt::print("{} to {}\n", printable(numbered(name, 0)), printable(numbered(name, poses.size() - 1)));
      any = any || !poses.empty();
    }
    return any ? success() : Status(Error{options_.map, "has no robot with keyframes to follow"});
  }

 private:
  std::string numbered(const std::string& name, std::size_t i) const {
    return fmt::format("{}{}_{:04}.png", without_ending(options_.png, ".png"), name, i);
  }
  static void say(std::size_t done, std::size_t count) {
    if (isatty(STDERR_FILENO) != 1) return;
    fmt::print(stderr, "\r{} of {} pictures{}", done, count, done == count ? "\n" : "");
    (void)std::fflush(stderr);
  }

  const ViewOptions& options_;
  render::Renderer& renderer_;
};

Status write_beside(const ViewOptions& o, const render::Scene& scene, render::Renderer& renderer) {
  std::vector<render::Scene> maps{scene};
  for (const std::string& file : o.beside) {
    auto other = read_map(file, o);
    if (!other) return other.error();
    maps.push_back(std::move(*other));
  }
  std::optional<render::Scene> whole;
  if (!o.as_in.empty()) {
    auto read = read_map(o.as_in, o);
    if (!read) return read.error();
    whole = std::move(*read);
  }
  auto image = render::draw_side_by_side(renderer, maps, o.style, whole ? &*whole : nullptr, o.plain);
  if (!image) return image.error();
  if (auto done = render::write_png(o.png, *image); !done) return done;
  fmt::print("{}\n", printable(o.png));
  return success();
}

Status write_pictures(const ViewOptions& o, const render::Scene& scene) {
  auto renderer = render::open_egl_renderer();
  if (!renderer) return renderer.error();
  if (!o.beside.empty()) return write_beside(o, scene, **renderer);
  const Pictures pictures(o, **renderer);
  if (!o.views.empty()) return pictures.views(scene);
  if (o.turntable > 0) return pictures.turntable(scene);
  if (o.follow_every > 0) return pictures.follow_all(scene);
  if (auto done = pictures.write(scene, camera_for(o, scene), o.png); !done) return done;
  fmt::print("{}\n", printable(o.png));
  return success();
}

// Colours the map by its distance from the other one and says what the distances are.
Status compare(const ViewOptions& o, render::Scene& scene) {
  auto other = read_map(o.compare, o);
  if (!other) return other.error();
  if (scene.mesh.vertices.empty() || other->mesh.vertices.empty())
    return Error{scene.mesh.vertices.empty() ? o.map : o.compare, "has no surface to compare"};
  *other = render::in_frame_of(std::move(*other), scene);
  const auto distances = render::distances_m(scene.mesh, other->mesh, o.compare_limit_m);
  scene.mesh.colors.clear();
  for (const float d : distances) scene.mesh.colors.push_back(render::distance_color(d, o.compare_limit_m));
  const auto s = render::summary(distances, o.compare_limit_m);
  fmt::print("distance from {}: median {:.1f} mm, 95 % within {:.1f} mm, {:.1f} % beyond {:.0f} mm\n",
             printable(o.compare), 1e3f * s.median_m, 1e3f * s.p95_m, 100 * s.beyond, 1e3f * o.compare_limit_m);
  if (s.beyond > 0.5f)
    fmt::print("most of {} is farther from it than --compare-limit: are both of one place, and in one frame?\n",
               printable(o.map));
  return success();
}

Status write_map_ply(const ViewOptions& o, const render::Scene& scene) {
  const mapping::Matrix3d R = render::upright_rotation(render::up_of(scene));
  return scene.mesh.triangles.empty() ? render::write_ply(o.ply, scene.points, R)
                                      : render::write_ply(o.ply, scene.mesh, R);
}

Status write_map_pcd(const ViewOptions& o, const render::Scene& scene) {
  const mapping::Matrix3d R = render::upright_rotation(render::up_of(scene));
  return scene.mesh.triangles.empty() ? render::write_pcd(o.pcd, scene.points, R)
                                      : render::write_pcd(o.pcd, scene.mesh, R);
}

}  // namespace

Status run_view(const ViewOptions& o) {
  auto scene = read_map(o.map, o);
  if (!scene) return scene.error();
  scene->up = render::up_of(*scene);  // once for all
  const auto& mesh = scene->mesh;
  fmt::print("{}: {} points, {} triangles, {} robots\n", printable(o.map),
             mesh.vertices.size() + scene->points.points.size(), mesh.triangles.size(), scene->robots.size());
  if (!o.compare.empty())
    if (auto done = compare(o, *scene); !done) return done;
  if (!o.png.empty())
    if (auto done = write_pictures(o, *scene); !done) return done;
  if (!o.glb.empty()) {
    if (auto done = render::write_glb(o.glb, *scene); !done) return done;
    fmt::print("{}\n", printable(o.glb));
  }
  if (!o.ply.empty()) {
    if (auto done = write_map_ply(o, *scene); !done) return done;
    fmt::print("{}\n", printable(o.ply));
  }
  if (!o.pcd.empty()) {
    if (auto done = write_map_pcd(o, *scene); !done) return done;
    fmt::print("{}\n", printable(o.pcd));
  }
  return success();
}

}  // namespace onemap::daemon
