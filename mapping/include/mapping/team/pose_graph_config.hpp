#pragma once
#include <cstddef>
#include <cstdint>

// The numbers of the pose graph, each with its reason.
namespace onemap::mapping {

// When links may join two chains, or close a loop of one. Wrong links that nothing contradicts pass any solver, so what
// joins is asked for more than what is added once joined.
struct JoinConfig {
  // Two links agree, and an own loop agrees with odometry, up to this: chi square of 6 degrees of freedom at 0.99.
  double chi2 = 16.81;
  // Random wrong links agree by chance in twos and threes; with four none of 20 simulated teams was joined wrongly.
  std::uint32_t links = 4;
  // Two doors that look alike give many links that agree, all from one place. Two places by chance are rare.
  std::uint32_t places = 2;
  // Ends on both chains are at least so far apart: then these are two places. While links are too few to tell from what
  // lies side by side (fewer than links_in_one_place), who went further must have met further apart, as a door is seen
  // from some metres before it on: up to half of how far the chain that went less far ever was from there.
  double place_distance_m = 1.0, place_share_of_way = 0.5, most_place_distance_m = 3.0;
  // Robots that met at one desk never come a metre apart: there so many agreeing links do instead, when one of the two
  // was hardly anywhere else, so that there is no other place to ask: that share of its anchors is near the links.
  std::uint32_t links_in_one_place = 12;
  double share_in_one_place = 0.67;
  // Two cameras so near each other that look the same way see one thing. Links that lay many anchors side by side where
  // there is no link are not what they say. Beyond what chance would miss, right ones of 50 simulated teams missed that
  // share in 6 at most, and a place that is like another one did in all but a few.
  double beside_m = 1.5, beside_cosine = 0.8, most_missed = 0.2;
  // Links of one chain have its odometry as a witness (chi2 above), which random ones do not pass: two are enough.
  std::uint32_t own_links = 2;
  // A second group of links that contradicts the first is a look-alike, and which of them is right is open while the
  // second has more than this share of the first.
  double second_group_share = 0.5;
  // Three chains' links close a ring up to this: chi square of 6 degrees of freedom at one in a million. Look-alikes
  // are wrong by metres, and a ring that is right must not part a map.
  double ring_chi2 = 38.3;
  // What one pair of anchors may contribute, the best by inliers: more of the same view say nothing new. Enough for
  // robots at one desk, whose every frame hangs on one anchor.
  std::uint32_t links_per_anchor_pair = 24;
  // Links of a pair of chains that are compared with each other (quadratic); the best by inliers.
  std::size_t links_compared = 400;
  // Steps of the exact search for the largest group; then the best so far counts. The heuristic is rarely worse.
  std::size_t clique_steps = 100'000;
};

// How sure a link is. Measured over 3,600 links of our recordings: 21.5 mm from truth at a mean of 75 inliers.
struct LinkNoise {
  double translation_m = 0.02;
  double rotation_rad = 0.0122;  // 0.7 degrees
  double inliers = 75;           // at so many; otherwise the sigmas go with 1 / sqrt(inliers)
  double least_share = 0.5;  // and never below this share: 1 cm and 0.35 degrees; calibration and time are not better
};

// Truncated least squares by graduated non-convexity (Yang and others 2020).
struct GncConfig {
  double barc2 = 16.81;  // a link counts up to this squared error: chi square of 6 degrees of freedom at 0.99
  double mu_step = 2;    // GTSAM and Kimera take 1.4 from an arbitrary start; ours holds the links that agree already
  double mu_cold = 0.25,
         mu_warm = 1.0;  // first shape: reaches to 5 x and 2 x barc2, and as far as what is trusted does
  double mu_end = 8;     // last shape: weights between 0 and 1 are left only within an eighth of barc2
  std::uint32_t rounds_cold = 50, rounds_warm = 10;
  std::uint32_t steps_a_round = 1;              // Gauss-Newton steps between two looks at the weights
  double drop_below = 0.1, return_above = 0.9;  // a link in use, a dropped one: verdicts do not flicker
};

struct PoseGraphConfig {
  JoinConfig join;
  LinkNoise link_noise;
  GncConfig gnc;
  // An anchor keeps its pose in use while every corner of its box moved less: a quarter of a 2 cm voxel.
  double keep_within_m = 0.005;
  // What one graph may hold; more is refused.
  std::size_t max_anchors = 16'384, max_links = 65'536;
};

}  // namespace onemap::mapping
