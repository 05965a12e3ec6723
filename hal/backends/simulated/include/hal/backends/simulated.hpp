#pragma once
#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "hal/backends.hpp"

namespace onemap::hal {

// `simulated:SCENE?key=value&key=value...`: a furnished room from formulas, seen by one robot of a team that walks
// through it with the camera in hand. The same address gives the same bytes on every machine, and frame k does not
// depend on the frames before it. All robots of one scene and seed see the same room, under the same light, from
// neighbouring places of one closed walk, so that their views overlap.
//
// SCENE: living-room, office, storage, empty-hall, corridor (its doors look alike on purpose), house, ring,
// blank-walls (most of what is seen has one brightness: what a colour camera follows is a few pictures, what a depth
// camera follows is corners and furniture, and at one place there is neither for a moment). No two scenes, and no two
// seeds of one scene, share a texture. In the house each robot walks its own of three rooms (robot 4
// the first again) and sees the same as its neighbour only at the passages: a round takes 18 s, 540 frames. The ring is
// a corridor of 60 m that leads into itself, with doors that look alike: the robots start at equal distances and walk
// round it in 100 s.
//
//   option  default  range         meaning
//   robot   1        1..robots     which robot of the team this camera belongs to
//   robots  3        1..64         robots in the team
//   frames  200      1..1000000    length of the stream; the walk closes after about 20 s in a room and goes on
//   seed    1        0..2^63-1     another room: textures, furniture, walks and noise
//   noise   kinect   kinect, none  kinect: quantised noisy disparity, shadows beside near things, holes on grazing and
//                                  dark places, range limits; blur, vignetting and noise on the colour. none: exact
//   near    0.5      0.4..2        metres; nearer depth is 0 (noise=kinect only)
//   far     5        1..8          metres; farther depth is 0 (noise=kinect only)
//   width   640      64..1920      pixels; the focal length scales with it (525 at 640)
//   height  480      48..1440      pixels
//   fps     30       1..120        frames a second, of the time stamps and of the walk
//   carried_at       never  1..1000000  the frame from which on it walks where the next robot does: somebody
//                                  carried it there
//   depth_late_ms    0  -50..50    after colour by which depth is measured, in place and in its time stamp
//
// Faults, for tests; the frame from which on, 1..1000000, never by default, and for how many frames:
//
//   unplug_at, back_after          it is gone (Grab::gone) from that frame on, for so many frames of its time
//   freeze_at                      it shows the picture and the depth of the frame before again and again
//   black_at, saturate_at          its pictures are black or white
//   no_depth_at                    its depth is 0
//   time_back_at                   its times are an hour too early
//   fault_for                      so many frames of each of these but unplug_at
//   fx_scale         1  0.5..2     the focal lengths that it claims, of the true ones
//
// An unknown scene, an unknown option or a value out of its range is an error that lists what is valid.
Result<std::unique_ptr<DepthCamera>> open_simulated(const CameraAddress& address);
Status check_simulated(const CameraAddress& address);

// Where the camera was at one frame. The camera frame is the optical one (x right, y down, z forward), the world is
// the room (z up, metres, origin on the floor below the walk's centre).
struct SimulatedPose {
  FrameTime time{};
  std::array<double, 3> t_world_camera_m{};
  std::array<double, 4> q_world_camera_xyzw{0, 0, 0, 1};  // unit quaternion, w >= 0
};

// The truth of one frame of the stream, by its index.
Result<std::function<SimulatedPose(std::uint64_t)>> simulated_pose(const CameraAddress& address);

// The truth of every frame that the address gives, oldest first: what TUM calls groundtruth.txt.
Result<std::vector<SimulatedPose>> simulated_truth(const CameraAddress& address);

// How far a place of the room is from its nearest surface, both in metres.
Result<std::function<double(const std::array<double, 3>&)>> simulated_surface(const CameraAddress& address);

}  // namespace onemap::hal
