#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "evaluation/evaluation.hpp"
#include "hal/base/text.hpp"

namespace onemap::evaluation {

namespace {

std::string surface_words(const TeamEvaluation& evaluation) {
  if (!evaluation.surface) return {};
  const SurfaceEvaluation& s = *evaluation.surface;
  return fmt::format(
      "surface: {} points, {:.4f} m rms, median {:.4f} m, 95 % within {:.4f} m, {:.1f} % beyond {:g} m\n", s.points,
      s.rms, s.median, s.p95, 100 * s.off, kOff_m);
}

}  // namespace

std::string to_json(const TeamEvaluation& evaluation) {
  using Json = nlohmann::ordered_json;
  Json robots = Json::array();
  for (const RobotEvaluation& r : evaluation.robots) {
    Json rpe = nullptr;
    if (r.rpe) rpe = Json::array({r.rpe->translation_m, r.rpe->rotation_deg});
    robots.push_back({{"estimate", printable(r.estimate_name)},
                      {"poses", r.poses},
                      {"coverage", r.coverage},
                      {"rpe", rpe},
                      {"ate_alone", r.ate_alone},
                      {"ate_joint", r.ate_joint},
                      {"median", r.median},
                      {"max", r.max}});
  }
  const Json team = {{"robots", evaluation.robots.size()}, {"poses", evaluation.poses},
                     {"coverage", evaluation.coverage},    {"ate", evaluation.ate},
                     {"median", evaluation.median},        {"max", evaluation.max}};
  Json json{{"robots", robots}, {"team", team}};
  if (const auto& s = evaluation.surface)
    json["surface"] = {{"map", printable(s->name)}, {"points", s->points}, {"rms", s->rms},
                       {"median", s->median},       {"p95", s->p95},       {"off", s->off}};
  return json.dump(1) + "\n";
}

std::string to_text(const TeamEvaluation& evaluation, const EvaluationSettings& settings) {
  std::string text;
  for (const RobotEvaluation& r : evaluation.robots) {
    text += fmt::format("{}: poses {} coverage {:.3f} ATE alone {:.4f} joint {:.4f} max {:.4f}",
                        printable(r.estimate_name), r.poses, r.coverage, r.ate_alone, r.ate_joint, r.max);
    if (r.rpe)
      text += fmt::format(" RPE/{:g}s {:.4f} m {:.3f} deg", settings.rpe_delta_s, r.rpe->translation_m,
                          r.rpe->rotation_deg);
    text += "\n";
  }
  return text +
         fmt::format("team of {}: poses {} coverage {:.3f} ATE {:.4f} median {:.4f} max {:.4f}\n",
                     evaluation.robots.size(), evaluation.poses, evaluation.coverage, evaluation.ate, evaluation.median,
                     evaluation.max) +
         surface_words(evaluation);
}

std::string to_table(const TeamEvaluation& evaluation, const EvaluationSettings& settings) {
  std::string text = fmt::format(
      "{:>6}  {:>8}  {:>9}  {:>9}  {:>9}  {:>9}  {:>8}  estimate\n{:>6}  {:>8}  {:>9}  {:>9}  {:>9}  {:>9}  {:>8}\n",
      "poses", "coverage", "ATE alone", "ATE joint", "ATE max", fmt::format("RPE {:g} s", settings.rpe_delta_s), "RPE",
      "", "", "m", "m", "m", "m", "deg");
  for (const RobotEvaluation& r : evaluation.robots) {
    const auto rpe = [&](double value, int digits) {
      return r.rpe ? fmt::format("{:.{}f}", value, digits) : std::string("-");
    };
    text += fmt::format("{:>6}  {:>8.3f}  {:>9.4f}  {:>9.4f}  {:>9.4f}  {:>9}  {:>8}  {}\n", r.poses, r.coverage,
                        r.ate_alone, r.ate_joint, r.max, rpe(r.rpe ? r.rpe->translation_m : 0, 4),
                        rpe(r.rpe ? r.rpe->rotation_deg : 0, 3), printable(r.estimate_name));
  }
  return text +
         fmt::format("team of {}: {} poses, coverage {:.3f}, ATE {:.4f} m, median {:.4f} m, max {:.4f} m\n",
                     evaluation.robots.size(), evaluation.poses, evaluation.coverage, evaluation.ate, evaluation.median,
                     evaluation.max) +
         surface_words(evaluation);
}

}  // namespace onemap::evaluation
