#include "daemon/view/view_options.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "daemon/command_line.hpp"

namespace onemap::daemon {

namespace {

constexpr const char* kProgram = "onemap-view";
constexpr int kMaxSide_px = 16384;

constexpr const char* kFooter =
    "Examples:\n"
    "  onemap-view global.glb --png global.png\n"
    "  onemap-view global.glb --png plan.png --view plan --size 1920x1080\n"
    "  onemap-view global.glb --png map.png --views fit top front    # map_fit.png ...\n"
    "  onemap-view global.glb --png paper.png --background white --plain --path-width 5\n"
    "  onemap-view local.ply --png desk.png --eye 0,-0.5,-1 --target 0,0,1.5\n"
    "  onemap-view r1/local.glb --beside r2/local.glb r3/local.glb --as-in r1/global.glb --png locals.png\n"
    "  onemap-view r1/local.glb --compare global.glb --png loss.png\n"
    "  onemap-view global.glb --png turn.png --turntable 120    # turn_0000.png ...\n"
    "  ffmpeg -framerate 30 -i turn_%04d.png -pix_fmt yuv420p turn.mp4\n"
    "  onemap-view global.glb --png way.png --follow-all 10     # way_robot1_0000.png ...\n"
    "  onemap-view global.glb --ply global.ply --points\n"
    "Exit status: 0 done, 1 a file or the renderer failed, 2 wrong options.\n";

// Words that CLI11 holds as text, and what they stand for.
struct Given {
  ViewOptions options;
  std::string size = "1280x720", background;
};

void declare_outputs(CLI::App& app, ViewOptions& o) {
  const auto output = [&](const char* name, std::string& file, const char* what) {
    app.add_option(name, file, what)->group("Output (at least one)")->type_name("FILE");
  };
  output("--png", o.png, "write a picture; of a sequence: FILE_0000.png, FILE_0001.png and so on");
  output("--glb", o.glb, "write a glTF 2.0 model: map, trajectories and cameras as named nodes");
  output("--ply", o.ply, "write the map as binary PLY, upright (+y is up)");
  output("--pcd", o.pcd, "write the map's points as binary PCD, upright (+y is up)");
}

void declare_what(CLI::App& app, ViewOptions& o) {
  auto* points = app.add_flag("--points", o.points, "only the points of a mesh")->group("What");
  app.add_flag("--mesh", o.mesh, "triangles; an error if the map has none")->group("What")->excludes(points);
  app.add_flag("--keep-crumbs", o.keep_crumbs, "keep pieces of surface below 200 vertices, which are noise")
      ->group("What");
  auto* beside = app.add_option("--beside", o.beside, "draw these maps beside MAP, each with its name and triangles");
  beside->group("What")->type_name("FILE ...");
  app.add_option("--as-in", o.as_in, "see them all in the direction in which this map of the team is seen")
      ->group("What")
      ->type_name("FILE")
      ->needs(beside);
  auto* compare = app.add_option("--compare", o.compare, "colour MAP by its distance from this map's surface");
  compare->group("What")->type_name("FILE")->excludes(beside);
  app.add_option("--compare-limit", o.compare_limit_m, "metres that are red")
      ->group("What")
      ->check(CLI::Range(0.001, 0.5))
      ->capture_default_str()
      ->needs(compare);
}

void declare_viewpoint(CLI::App& app, ViewOptions& o) {
  const char* group = "Viewpoint";
  app.add_option(
         "--view", o.view,
         "fit: the room from behind and above the cameras, or where they looked all around as a doll's house; top: "
         "from above; plan: a floor plan with a grid of metres; front: what the first camera saw; follow: over "
         "the shoulder of the last camera")
      ->group(group)
      ->check(CLI::IsMember({"fit", "top", "plan", "front", "follow"}))
      ->capture_default_str();
  auto* views = app.add_option("--views", o.views, "several of these at once: FILE_VIEW.png of each");
  views->group(group)->type_name("VIEW ...")->check(CLI::IsMember({"fit", "top", "plan", "front", "follow"}));
  auto* eye =
      app.add_option("--eye", o.eye, "look from here, X,Y,Z in metres; x right, y down, z ahead of the first camera");
  eye->group(group)->delimiter(',')->expected(3)->type_name("X,Y,Z")->excludes(views);
  app.add_option("--target", o.target, "look at this point (with --eye; default: the map's origin)")
      ->group(group)
      ->delimiter(',')
      ->expected(3)
      ->type_name("X,Y,Z")
      ->needs(eye);
  auto* turn = app.add_option("--turntable", o.turntable, "a sequence of N pictures once round the map");
  turn->group(group)->type_name("N")->check(CLI::Range(2, 100000))->excludes(views);
  app.add_option("--follow-all", o.follow_every,
                 "a sequence: over each robot's shoulder at every K-th place of its way")
      ->group(group)
      ->type_name("K")
      ->check(CLI::Range(1, 1000000))
      ->excludes(turn)
      ->excludes(eye)
      ->excludes(views);
}

void declare_look(CLI::App& app, Given& g) {
  const char* group = "Look";
  render::Style& style = g.options.style;
  app.add_option("--size", g.size, "width and height in pixels")->group(group)->type_name("WxH")->capture_default_str();
  app.add_flag("--plain", g.options.plain, "without names, bar, axes and grid")->group(group);
  app.add_option("--background", g.background, "white, black, grey, or RRGGBB (default: light grey)")->group(group);
  app.add_option("--path-width", style.path_width_px, "of trajectories in pixels; 0: none")
      ->group(group)
      ->check(CLI::Range(0.0, 50.0))
      ->capture_default_str();
  app.add_option("--point-size", style.point_size_m, "side of a point in metres (default: by their spacing)")
      ->group(group)
      ->check(CLI::PositiveNumber);
  app.add_option("--shading", style.shading, "0: the photographs' colours, 1: strong light and shadow")
      ->group(group)
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  app.add_option("--depth-cues", style.depth_cues, "dark hollows and edges; 0: none, 1: strong")
      ->group(group)
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  app.add_flag("--both-sides", style.both_sides,
               "draw surfaces from behind too (else one looks through walls into the room)")
      ->group(group);
}

std::string parse_size(const std::string& text, render::Style& style) {
  int used = 0;
  if (std::sscanf(text.c_str(), "%5dx%5d%n", &style.width_px, &style.height_px, &used) == 2 &&  // NOLINT(cert-err34-c)
      static_cast<std::size_t>(used) == text.size() && std::min(style.width_px, style.height_px) > 0 &&
      std::max(style.width_px, style.height_px) <= kMaxSide_px)
    return {};
  return fmt::format("--size: {} is not WIDTHxHEIGHT, for example 1280x720, of at most {} pixels each", text,
                     kMaxSide_px);
}

std::string parse_background(const std::string& text, render::Style& style) {
  if (text.empty()) return {};
  if (text == "white") return style.background = {255, 255, 255}, "";
  if (text == "black") return style.background = {0, 0, 0}, "";
  if (text == "grey") return style.background = {128, 128, 128}, "";
  unsigned value = 0;
  const char* end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data(), end, value, 16);
  if (text.size() != 6 || parsed.ec != std::errc{} || parsed.ptr != end)
    return fmt::format("--background: {} is neither white, black, grey nor RRGGBB, for example e8eef4", text);
  for (std::size_t c = 0; c < 3; ++c) style.background[c] = static_cast<std::uint8_t>(value >> (16 - 8 * c));
  return {};
}

// What CLI11's ranges let through: not a number, and infinitely far.
std::string check_numbers(const ViewOptions& o) {
  const auto finite = [](const std::vector<float>& v) {
    return std::all_of(v.begin(), v.end(), [](float x) { return std::isfinite(x); });
  };
  if (!finite(o.eye)) return "--eye: expected three finite numbers";
  if (!finite(o.target)) return "--target: expected three finite numbers";
  if (!finite({o.style.shading})) return "--shading: expected a number from 0 to 1";
  if (!finite({o.style.depth_cues})) return "--depth-cues: expected a number from 0 to 1";
  if (!finite({o.style.point_size_m})) return "--point-size: expected a finite number of metres";
  if (!finite({o.style.path_width_px})) return "--path-width: expected a finite number of pixels";
  if (!finite({o.compare_limit_m})) return "--compare-limit: expected a finite number of metres";
  return {};
}

// What is wrong with options that are right one by one.
std::string check(const ViewOptions& o) {
  if (o.png.empty() && o.glb.empty() && o.ply.empty() && o.pcd.empty())
    return "nothing to do: give --png, --glb, --ply or --pcd";
  const bool sequence = o.turntable > 0 || o.follow_every > 0;
  if (o.png.empty() && (sequence || !o.beside.empty() || !o.views.empty()))
    return "a sequence, --views and --beside are pictures: give --png";
  if (!o.views.empty() && !o.beside.empty()) return "--beside draws one picture, not several views";
  if (sequence && !o.beside.empty()) return "--beside draws one picture, not a sequence";
  return {};
}

}  // namespace

Parsed<ViewOptions> parse_view_options(const std::vector<std::string>& arguments) {
  CLI::App app{"Draws a saved map off-screen, or converts it.", kProgram};
  Given given;
  app.add_option("MAP", given.options.map, "the map: a .ply, .glb or .omap that onemap wrote")->required();
  declare_outputs(app, given.options);
  declare_what(app, given.options);
  declare_viewpoint(app, given.options);
  declare_look(app, given);
  app.footer(kFooter);
  if (auto ending = parse_command_line(app, arguments)) return {*ending, std::nullopt};
  std::string wrong = parse_size(given.size, given.options.style);
  if (wrong.empty()) wrong = parse_background(given.background, given.options.style);
  if (wrong.empty()) wrong = check_numbers(given.options);
  if (wrong.empty()) wrong = check(given.options);
  if (!wrong.empty()) return {{Exit::usage, complaint(kProgram, wrong)}, std::nullopt};
  return {{}, std::move(given.options)};
}

}  // namespace onemap::daemon
