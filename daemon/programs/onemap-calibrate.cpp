// onemap-calibrate: where a camera's depth lens is, from a recording of an ordinary room.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <vector>

#include "daemon/command_line.hpp"
#include "hal/backends/replay.hpp"
#include "hal/base/file.hpp"
#include "hal/base/text.hpp"
#include "hal/frame_pool.hpp"
#include "hal/imaging/rig_estimate.hpp"

namespace {

using namespace onemap;
using namespace onemap::daemon;
using namespace onemap::hal;

constexpr const char* kProgram = "onemap-calibrate";
constexpr const char* kDescription =
    "Estimates where a camera's depth lens is beside its colour lens, and the offset of its depth, from a "
    "recording.\n\n"
    "RECORDING is a folder as onemapctl record makes it, of a walk through a furnished room with things near and far;\n"
    "its depth is as the depth lens sees it (v4l2:?registration=none). NOMINAL is a calibration to begin with: both\n"
    "lenses, and where they are within some millimetres and a degree. What was told goes to OUT, which\n"
    "v4l2:?calibration=OUT reads; what the recording cannot tell stays as it was, and is said.";
constexpr const char* kFooter =
    "Examples:\n"
    "  onemap-calibrate recordings/1 --from d435i.txt --out my-d435i.txt\n"
    "  onemap-calibrate recordings/1 --from d435i.txt --baseline 0.0148\n"
    "\nExit status: 0 done, 1 it cannot be told, and why, 2 wrong options.";

struct Wish {
  std::string recording, nominal, out;
  imaging::RigEstimator::Settings settings;
  std::size_t images = 24;
  bool json = false;
};

Result<imaging::RigCalibration> scaled(const imaging::RigCalibration& nominal, const Intrinsics& recorded,
                                       const std::string& place) {
  imaging::RigCalibration rig = nominal;
  const imaging::ImageSize size = imaging::size_of(recorded);
  for (Intrinsics* k : {&rig.colour, rig.depth ? &*rig.depth : nullptr}) {
    if (k == nullptr) continue;
    const auto fitting = imaging::scaled_to(*k, size);
    if (!fitting)
      return Error{place,
                   fmt::format("{}: a recording has depth and colour at one size, {}x{}, and a camera whose {} "
                               "images have another shape cannot be calibrated by one",
                               fitting.error().reason, size.width, size.height, k == &rig.colour ? "colour" : "depth")};
    *k = *fitting;
  }
  if (rig.colour.depth_scale != recorded.depth_scale)
    return Error{place, fmt::format("depth_scale is {:g}, and {:g} in the recording", rig.colour.depth_scale,
                                    recorded.depth_scale)};
  return rig;
}

// So many images at equal distances.
Status show(DepthCamera& camera, std::size_t images, imaging::RigEstimator& estimator) {
  FramePool pool(camera.intrinsics(), 1);
  Frame frame = pool.acquire();
  const std::uint64_t step = std::max<std::uint64_t>(1, camera.frames_expected() / images);
  for (std::uint64_t i = 0;;) {
    const Grab grab = camera.grab(frame, {});
    if (grab == Grab::end) return success();
    if (grab != Grab::frame) continue;
    if (i++ % step == 0) estimator.add(frame.view().rgb, frame.view().depth);
  }
}

Result<imaging::RigEstimator::Estimated> run(const Wish& wish) {
  const auto text = read_text_file(wish.nominal);
  if (!text) return text.error();
  const auto nominal = imaging::parse_rig_calibration(*text, wish.nominal);
  if (!nominal) return nominal.error();
  const auto address = parse_camera_address("replay:" + wish.recording);
  if (!address) return address.error();
  const auto camera = open_replay(*address);
  if (!camera) return camera.error();
  const auto rig = scaled(*nominal, (*camera)->intrinsics(), wish.nominal);
  if (!rig) return rig.error();
  auto estimator = imaging::RigEstimator::create(*rig, wish.settings);
  if (!estimator) return Error{wish.nominal, estimator.error().reason};
  if (const Status status = show(**camera, wish.images, *estimator); !status) return status.error();
  auto estimated = estimator->estimate();
  if (!estimated) return Error{wish.recording + " cannot tell it", estimated.error().reason};
  return estimated;
}

using Json = nlohmann::ordered_json;

// Without a deviation it is as it was.
Json json_of(double value, std::optional<double> sigma) {
  return {{"value", value}, {"sigma", sigma ? Json(*sigma) : Json()}};
}

// What words_of() says, for programs; the file's own keys name the numbers.
Json json_of(const imaging::RigEstimator::Estimated& e) {
  const auto& t = e.rig.pose.translation_m;
  const auto turn = imaging::turn_rad(e.rig.pose);
  Json json{{"class", "CALIBRATION"}, {"edges", e.lens.edges}, {"unrest_px", e.lens.unrest_px}, {"planes", e.planes}};
  for (std::size_t i = 0; i < 3; ++i) json[fmt::format("turn_{}_rad", "xyz"[i])] = json_of(turn[i], e.lens.sigma[i]);
  for (std::size_t i = 0; i < 3; ++i)
    json[fmt::format("colour_from_depth_{}", "xyz"[i])] =
        json_of(t[i], i < 2 ? std::optional(e.lens.sigma[3 + i]) : std::nullopt);
  json["depth_offset_m"] = json_of(e.rig.depth_offset_m, e.offset_told ? std::optional(e.offset.sigma) : std::nullopt);
  json["depth_scale"] = json_of(e.rig.colour.depth_scale, e.scale ? std::optional(e.scale->sigma) : std::nullopt);
  return json;
}

std::string answer(const Wish& wish, const imaging::RigEstimator::Estimated& estimated) {
  if (!wish.json) return imaging::words_of(estimated);
  Json json = json_of(estimated);
  if (!wish.out.empty()) json["out"] = wish.out;
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Ending calibrate(const std::vector<std::string>& arguments) {
  CLI::App app(kDescription, kProgram);
  Wish wish;
  double baseline_m = 0;
  app.add_option("recording", wish.recording, "a folder that replay: reads")->required()->type_name("RECORDING");
  app.add_option("--from", wish.nominal, "the calibration to begin with")->required()->type_name("NOMINAL");
  app.add_option("--out", wish.out, "where the calibration goes; without it, it is only told")->type_name("OUT");
  auto* baseline =
      app.add_option("--baseline", baseline_m, "the lenses' distance, if it is known: it tells depth's scale")
          ->type_name("METRES");
  app.add_option("--images", wish.images, "how many of the recording's images are looked at (default 24)")
      ->type_name("N")
      ->check(CLI::Range(4, 200));
  app.add_flag("--json", wish.json, "what was told as a JSON object instead of words");
  app.footer(kFooter);
  if (auto ending = parse_command_line(app, arguments)) return *ending;
  if (baseline->count() > 0) wish.settings.baseline_m = baseline_m;
  const auto estimated = run(wish);
  if (!estimated) return {Exit::failed, complaint(kProgram, estimated.error().text())};
  if (wish.out.empty()) return {Exit::done, answer(wish, *estimated)};
  const std::string words = imaging::words_of(*estimated);
  std::string file = fmt::format("# By onemap-calibrate from {}\n", printable(wish.recording));
  for (std::size_t at = 0; at < words.size(); at = words.find('\n', at) + 1)
    file += "# " + words.substr(at, words.find('\n', at) - at) + "\n";
  if (const Status status = write_text_file(wish.out, file + imaging::text_of(estimated->rig)); !status)
    return {Exit::failed, complaint(kProgram, status.error().text())};
  return {Exit::done, answer(wish, *estimated)};
}

}  // namespace

int main(int argc, char** argv) {
  return run_program(kProgram, argc, argv, [](const auto& arguments) { return end(calibrate(arguments)); });
}
