#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "evaluation/evaluation.hpp"
#include "hal/base/text.hpp"

namespace onemap::evaluation {

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
  return Json{{"robots", robots}, {"team", team}}.dump(1) + "\n";
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
  return text + fmt::format("team of {}: poses {} coverage {:.3f} ATE {:.4f} median {:.4f} max {:.4f}\n",
                            evaluation.robots.size(), evaluation.poses, evaluation.coverage, evaluation.ate,
                            evaluation.median, evaluation.max);
}

}  // namespace onemap::evaluation
