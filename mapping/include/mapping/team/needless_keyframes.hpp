#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "mapping/records/solution.hpp"
#include "mapping/team/own_places.hpp"
#include "mapping/team/team_member.hpp"

namespace onemap::mapping {

// Which of this robot's keyframes say nothing that it has not seen before: what its log holds of what it saw grows with
// the area and not with the time. Such a one has an earlier one, by a minute or more, that is as near as odometry
// between two keyframes, looks the same way, and has features like it. The earlier one stays, for what comes back to a
// place is joined to whatever of it is kept: were it the later one, each visit would be joined to the last one alone,
// and the map would drift from visit to visit. Where they are follows from the solution, so loops must have been
// closed. Of each that goes stays its place: the chain of poses stays whole. Used by one thread.
class NeedlessKeyframes {
 public:
  // Positions in the log that were not named before, ascending.
  std::vector<std::size_t> look(const RobotId& self, const TeamMember& own, const SolvedRobot& solved,
                                OwnPlaces& places);

 private:
  struct View {
    std::size_t position = 0;
    FrameTime time{};
    Pose T_map_keyframe;
  };
  static std::vector<View> views(const TeamMember& own, const SolvedRobot& solved);
  struct Tried {  // those before it that it was compared with
    std::size_t count = 0;
    std::uint32_t last = 0;
    bool operator==(const Tried&) const = default;
  };
  static std::set<std::uint32_t> before(const View& view, const std::vector<View>& kept);
  static bool was_seen_before(const RecordPtr& record, const std::set<std::uint32_t>& before, PlaceIndex& index);
  bool is_tried(std::size_t position, const std::set<std::uint32_t>& before) const;

  std::uint64_t life_ = 0;
  std::set<std::size_t> named_;         // and still there
  std::map<std::size_t, Tried> tried_;  // by position
};

// What remains of a keyframe: its place.
KeyframeRecord place_alone(const KeyframeRecord& keyframe);

}  // namespace onemap::mapping
