#pragma once
#include <optional>
#include <vector>

#include "daemon/capture.hpp"
#include "daemon/config.hpp"
#include "daemon/log.hpp"
#include "daemon/map_drawing.hpp"
#include "daemon/outputs.hpp"
#include "daemon/pictures.hpp"
#include "daemon/pipeline.hpp"
#include "daemon/radio.hpp"
#include "daemon/report.hpp"
#include "daemon/team.hpp"
#include "mapping/team/survey.hpp"

namespace onemap::daemon {

// What a robot writes when its threads have stopped: trajectories, the floor plan, pictures and models, the report. One
// thing that cannot be written keeps none of the others from being written.
class Harvest {
 public:
  // Everything must outlive this object.
  struct Sources {
    const Capture& capture;
    const Pipeline& pipeline;
    const Team& team;
    const Radio& radio;
    bool agreed;
    double peak_rss_mb;
  };
  Harvest(const Config& config, const Sources& sources, Log& log) : config_(config), from_(sources), log_(log) {}

  // Quick: what takes long (pictures, models, the floor plan) is left out. The first error; each is logged as it
  // happens.
  enum class Extent { everything, quick };
  Status write(Extent extent = Extent::everything);
  // The global map and everybody's way in it, as save_map() has it; nothing while there is none.
  std::optional<std::vector<std::uint8_t>> saved_map() const;

 private:
  void say_costs() const;
  void write_what_takes_long();
  Status write_trajectories() const;
  Status write_graph() const;
  Status write_plan();
  void say_plan(Duration took) const;
  MapSource source() const;
  std::vector<MapPicture> pictures() const;
  Status draw();
  Report report() const;
  RobotReport robot_report() const;
  void keep(const Status& status);

  const Config& config_;
  const Sources from_;
  Log& log_;
  Status first_ = success();
  std::vector<Merge> merges_;
  std::optional<mapping::Survey> survey_;  // under the floor plan, when there is one
  std::uint64_t vertices_ = 0;             // of the global map's files when there are such, else of the local one's
};

}  // namespace onemap::daemon
