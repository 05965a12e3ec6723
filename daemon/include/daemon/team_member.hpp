#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/base/record.hpp"
#include "mapping/records/finished.hpp"
#include "mapping/records/solution.hpp"
#include "mapping/records/trajectory.hpp"

namespace onemap::daemon {

// One robot of the team by its records of one life. Keyframes and submaps stay encoded; they are decoded while they are
// worked on.
struct TeamMember {
  std::uint64_t incarnation = 0;  // of the life that these records are from: the newest one heard of
  std::string name, camera;       // no name: no Hello yet
  std::optional<mapping::FinishedRecord> finished;
  std::vector<std::shared_ptr<const Record>> keyframes, submaps;  // those that decode, in order of their log
  std::size_t keyframes_refused = 0, submaps_refused = 0;  // malformed ones count for completeness, and nothing else
  bool poses_refused = false;                              // some are missing for good
  std::vector<mapping::StampedPose> poses;
  std::vector<mapping::QuantizedPose> keyframe_poses;
  std::optional<mapping::SolutionRecord> solution;  // the last one that it published

  // Takes a record of this robot, but for links, which are the team's. The error says what is malformed.
  Status apply(const std::shared_ptr<const Record>& record);

  bool keyframes_complete() const { return finished && keyframes.size() + keyframes_refused >= finished->keyframes; }
  bool complete() const {
    return keyframes_complete() && submaps.size() + submaps_refused >= finished->submaps &&
           (poses_refused || poses.size() >= finished->tracked);
  }
};

}  // namespace onemap::daemon
