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

// Which of this robot's keyframes need not be seen any more, because it has looked from there again: what its log holds
// of what it saw grows with the area and not with the time. Such a one has a later one, by a minute or more, that is as
// near as odometry between two keyframes, looks the same way, and has features like it. Where they are follows from the
// solution, so loops must have been closed. Of each stays its place: the chain of poses stays whole. Used by one
// thread.
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
  static std::set<std::uint32_t> since(const View& view, const std::vector<View>& kept);
  bool is_seen_again(const RecordPtr& record, std::size_t position, const std::set<std::uint32_t>& since,
                     PlaceIndex& index);

  std::uint64_t life_ = 0;
  std::set<std::size_t> named_;                 // and still there
  std::map<std::size_t, std::uint32_t> tried_;  // positions, with the last one that each was compared with
};

// What remains of a keyframe: its place.
KeyframeRecord place_alone(const KeyframeRecord& keyframe);

}  // namespace onemap::mapping
