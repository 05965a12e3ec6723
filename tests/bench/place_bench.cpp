// Place recognition and the keyframe's bytes on recordings with truth: four chains of one desk (three cuts of fr1_xyz,
// fr1_rpy_a), a keyframe every 10 cm or 8 degrees.
//   links:  every two keyframes of unlike chains are verified as they were before (int8 descriptors at ratio 0.9,
//           lossless points and depths) and as records hold them (256 bits at 0.95, and what the coding does to points
//           and depths). Counted are right links: within 12 cm and 6 degrees of truth. Another RANSAC seed shows what
//           is chance.
//   recall: each keyframe asks for the others of other chains; R@k = right links among the first k, over min(k, right
//           links of that keyframe). The place index beside exhaustive search with the same votes and beside matching
//           all pairs, with the processor time of one thread.
//   bench_place [DATA_FOLDER] [--no-links] [--copies N]
#include <fmt/core.h>
#include <time.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <set>

#include "hal/backends.hpp"
#include "hal/backends/replay.hpp"
#include "hal/base/splitmix.hpp"
#include "hal/frame_pool.hpp"
#include "local/tracking/front_end.hpp"
#include "local/tracking/keyframe_record.hpp"
#include "mapping/team/candidates.hpp"
#include "support/poses.hpp"
#include "support/tum_recording.hpp"
#include "team/place_search.hpp"
#include "team/verify_clouds.hpp"

using namespace onemap;
using namespace onemap::mapping;

namespace {

const RobotId kNobody = RobotId::from_name("nobody");  // whose keyframes only make the index large

double cpu_ms() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) / 1e6;
}

struct View {
  int chain = 0;
  Pose T_world_camera;
  std::size_t bytes = 0;
  Cloud before;           // int8, lossless
  Cloud before_80;        // with the depth grid of 80 x 60 that records had
  Cloud now;              // from the record's bytes
  KeyframeRecord record;  // decoded
  PlaceId id() const { return {RobotId::from_name(std::string(1, static_cast<char>('a' + chain))), 1, 0}; }
};

void add_cells(Cloud& cloud) {
  for (const Vector3f& p : cloud.grid.points)
    if (p.z() > 0) cloud.cells.push_back(p);
}

Cloud cloud_before(const MapKeyframe& keyframe) {
  Cloud out;
  out.features.set.kind = DescriptorKind::surf;
  const FeatureFrame& f = keyframe.features;
  for (std::size_t i = 0; i < f.size(); ++i) {
    if (!f.has_depth(i)) continue;
    out.features.set.keypoints.push_back(f.set.keypoints[i]);
    out.features.set.descriptors.push_back(f.set.descriptors[i]);
    out.features.ray.push_back(f.ray[i]);
    out.features.point.push_back(f.point[i]);
  }
  grid_cloud(keyframe, out.grid);
  add_cells(out);
  return out;
}

Cloud halved(const Cloud& cloud, const MapKeyframe& keyframe) {
  Cloud out;
  out.features = cloud.features;
  hal::Intrinsics k;
  k.width = kGridWidth / 2;
  k.height = kGridHeight / 2;
  k.fx = keyframe.grid_fx / 2, k.fy = keyframe.grid_fy / 2, k.cx = keyframe.grid_cx / 2, k.cy = keyframe.grid_cy / 2;
  k.depth_scale = 4000;
  std::vector<std::uint16_t> depth;
  for (int v = 0; v < kGridHeight; v += 2)
    for (int u = 0; u < kGridWidth; u += 2)
      depth.push_back(keyframe.grid_depth[static_cast<std::size_t>(v * kGridWidth + u)]);
  organize(depth, k, k.width, k.height, out.grid);
  add_cells(out);
  return out;
}

struct Costs {
  double encode_ms = 0, decode_ms = 0, unpack_ms = 0;
};

View view_of(const MapKeyframe& keyframe, Costs& costs) {
  View out;
  KeyframeRecord record;
  fill_record(keyframe, record);
  const double t0 = cpu_ms();
  const auto body = encode(record);
  const double t1 = cpu_ms();
  out.record = decode_keyframe(body).value();
  const double t2 = cpu_ms();
  out.now = unpack(out.record);
  costs.encode_ms += t1 - t0, costs.decode_ms += t2 - t1, costs.unpack_ms += cpu_ms() - t2;
  out.bytes = body.size();
  out.before = cloud_before(keyframe);
  out.before_80 = halved(out.before, keyframe);
  return out;
}

bool far_apart(const Pose& a, const Pose& b) {
  const Pose off = a.inverse() * b;
  return off.t.norm() > 0.10 || test::rotation_angle(off.R) > 8 / 57.29578;
}

void add_chain(const std::string& folder, const std::string& cut, int chain, std::vector<View>& views, Costs& costs) {
  const test::TumRecording recording{folder};
  const std::array<hal::Backend, 1> backends{{{"replay", "", hal::open_replay}}};
  auto camera = std::move(hal::open_camera(backends, "replay:" + folder + cut).value());
  const hal::Intrinsics k = camera->intrinsics();
  hal::FramePool pool(k, 2);
  FrontEnd front_end({}, k);
  Observed seen = front_end.make_observed();
  OrganizedCloud grid;
  std::optional<Pose> last;
  for (hal::Grab grab = hal::Grab::frame; grab != hal::Grab::end;) {
    hal::Frame frame = pool.acquire();
    grab = camera->grab(frame, std::chrono::milliseconds(0));
    if (grab != hal::Grab::frame) continue;
    Pose T;
    const auto time = frame.view().depth_time.time_since_epoch().count();
    if (!recording.truth_at(static_cast<double>(time) / 1e9, T) || (last && !far_apart(*last, T))) continue;
    last = T;
    front_end.observe(frame.view(), {}, seen);
    organize(frame.view().depth, k, kGridWidth, kGridHeight, grid);
    MapKeyframe keyframe;
    copy_features(seen.features, keyframe.features);
    store_grid(grid, keyframe);
    View view = view_of(keyframe, costs);
    view.chain = chain;
    view.T_world_camera = T;
    views.push_back(std::move(view));
  }
}

using Links = std::set<std::pair<std::size_t, std::size_t>>;

struct Kind {
  const char* name;
  Cloud View::*cloud;
  float ratio;
  std::uint64_t seed;
};

// Right links of all pairs of unlike chains.
Links verify_all(const std::vector<View>& views, const Kind& kind) {
  VerifyConfig config;
  config.max_ratio = kind.ratio;
  config.seed = kind.seed;
  Links right;
  int wrong = 0, pairs = 0, inliers = 0;
  double error_mm = 0;
  std::map<LinkReason, int> reasons;
  const double t0 = cpu_ms();
  for (std::size_t i = 0; i < views.size(); ++i)
    for (std::size_t j = i + 1; j < views.size(); ++j) {
      if (views[i].chain == views[j].chain) continue;
      ++pairs;
      const PairResult found = verify_clouds(views[i].*kind.cloud, views[j].*kind.cloud, config).result;
      ++reasons[found.reason];
      if (found.reason != LinkReason::accepted) continue;
      const Pose off = (views[i].T_world_camera.inverse() * views[j].T_world_camera).inverse() * found.T_r_s;
      const bool good = off.t.norm() < 0.12 && test::rotation_angle(off.R) < 6 / 57.29578;
      if (!good) {
        ++wrong;
        continue;
      }
      right.emplace(i, j);
      inliers += found.inliers;
      error_mm += 1e3 * off.t.norm();
    }
  const double ms = cpu_ms() - t0, n = static_cast<double>(std::max<std::size_t>(right.size(), 1));
  fmt::print("{:34} {:6} {:6} {:6} {:8.1f} {:9.1f} {:7.2f}   refused:", kind.name, pairs, right.size(), wrong,
             inliers / n, error_mm / n, ms / pairs);
  for (const auto& [reason, count] : reasons)
    if (reason != LinkReason::accepted) fmt::print(" {}:{}", static_cast<int>(reason), count);
  fmt::print("\n");
  std::fflush(stdout);
  return right;
}

using Ranking = std::vector<std::size_t>;  // views, best first

struct Recall {
  double first = 0, ten = 0, twenty = 0, ms = 0;
  int queries = 0;
};

Recall recall_of(const std::vector<Ranking>& rankings, const Links& right, double ms) {
  Recall out;
  for (std::size_t q = 0; q < rankings.size(); ++q) {
    const auto is_right = [&](std::size_t i) { return right.contains({std::min(q, i), std::max(q, i)}); };
    std::size_t all = 0;
    for (std::size_t i = 0; i < rankings.size(); ++i) all += is_right(i);
    if (all == 0) continue;
    ++out.queries;
    const auto within = [&](std::size_t k) {
      const auto n = std::min(k, rankings[q].size());
      const auto hits =
          std::count_if(rankings[q].begin(), rankings[q].begin() + static_cast<std::ptrdiff_t>(n), is_right);
      return static_cast<double>(hits) / static_cast<double>(std::min(k, all));
    };
    out.first += within(1), out.ten += within(10), out.twenty += within(20);
  }
  for (double* sum : {&out.first, &out.ten, &out.twenty}) *sum /= std::max(out.queries, 1);
  out.ms = ms / static_cast<double>(rankings.size());
  return out;
}

void print(const char* name, const Recall& r) {
  fmt::print("{:44} {:6} {:7.3f} {:7.3f} {:7.3f} {:8.2f}\n", name, r.queries, r.first, r.ten, r.twenty, r.ms);
  std::fflush(stdout);
}

std::vector<BinaryFeature> features_of(const View& view, std::size_t most) {
  auto out = binary_features(view.record);
  out.resize(std::min(out.size(), most));
  return out;
}

PlaceId id_of(const std::vector<View>& views, std::size_t i) {
  PlaceId id = views[i].id();
  id.keyframe = static_cast<std::uint32_t>(i);
  return id;
}

// The same votes over all features there are.
std::vector<Ranking> exhaustive(const std::vector<View>& views, std::int32_t max_distance) {
  std::vector<Ranking> out;
  for (const View& query : views) {
    std::vector<std::uint64_t> votes(views.size());
    std::size_t asked = 0;
    for (const View& view : views) asked += view.chain != query.chain;
    for (const KeyframeFeature& f : query.record.features) {
      std::vector<std::pair<std::size_t, std::int32_t>> near;
      for (std::size_t i = 0; i < views.size(); ++i) {
        if (views[i].chain == query.chain) continue;
        std::int32_t best = max_distance + 1;
        for (const KeyframeFeature& g : views[i].record.features)
          if (g.laplacian == f.laplacian) best = std::min(best, hamming_distance(f.bits, g.bits));
        if (best <= max_distance) near.emplace_back(i, best);
      }
      const auto rarity = place::log2_fixed(2 * asked + 2) - place::log2_fixed(2 * near.size() + 1);
      for (const auto& [i, d] : near)
        votes[i] += std::uint64_t{rarity} * static_cast<std::uint64_t>(max_distance + 1 - d);
    }
    Ranking ranking;
    for (std::size_t i = 0; i < views.size(); ++i)
      if (votes[i] > 0) ranking.push_back(i);
    std::ranges::stable_sort(ranking, [&](std::size_t x, std::size_t y) { return votes[x] > votes[y]; });
    out.push_back(std::move(ranking));
  }
  return out;
}

// Matching the strongest features of all pairs, as the mode `all-pairs` does.
std::vector<Ranking> all_pairs(const std::vector<View>& views, float ratio, Cloud View::*cloud) {
  MatchConfig config;
  config.max_ratio = ratio;
  Matcher matcher(config, 128);
  std::vector<FeatureSet> strongest;
  for (const View& view : views) {
    strongest.push_back((view.*cloud).features.set);
    strongest.back().keypoints.resize(std::min<std::size_t>(128, strongest.back().keypoints.size()));
    strongest.back().descriptors.resize(strongest.back().keypoints.size());
  }
  std::vector<Ranking> out;
  for (std::size_t q = 0; q < views.size(); ++q) {
    std::vector<std::size_t> matches(views.size());
    for (std::size_t i = 0; i < views.size(); ++i)
      if (views[i].chain != views[q].chain) matches[i] = matcher.match(strongest[q], strongest[i]).size();
    Ranking ranking;
    for (std::size_t i = 0; i < views.size(); ++i)
      if (matches[i] > 0) ranking.push_back(i);
    std::ranges::stable_sort(ranking, [&](std::size_t x, std::size_t y) { return matches[x] > matches[y]; });
    out.push_back(std::move(ranking));
  }
  return out;
}

std::vector<Ranking> ask(PlaceIndex& index, const std::vector<View>& views, std::size_t features) {
  std::vector<Ranking> out;
  for (std::size_t q = 0; q < views.size(); ++q) {
    const RobotId own = views[q].id().robot;
    Ranking ranking;
    for (const Place& place : index.query(views[q].record.descriptor_kind, features_of(views[q], features), 20,
                                          [&](const PlaceId& id) { return id.robot != own && id.robot != kNobody; }))
      ranking.push_back(place.id.keyframe);
    out.push_back(std::move(ranking));
  }
  return out;
}

void fill(PlaceIndex& index, const std::vector<View>& views, std::size_t features) {
  for (std::size_t i = 0; i < views.size(); ++i)
    index.insert(id_of(views, i), views[i].record.descriptor_kind, features_of(views[i], features));
}

// Keyframes that are nobody's: copies with up to 70 bits of each feature flipped.
void add_copies(PlaceIndex& index, const std::vector<View>& views, std::size_t copies, std::size_t features) {
  SplitMix random(5);
  for (std::uint32_t n = 0; n < copies; ++n) {
    auto some = features_of(views[n % views.size()], features);
    for (BinaryFeature& f : some)
      for (std::size_t flips = random.below(71); flips > 0; --flips) {
        const std::size_t bit = random.below(256);
        f.bits[bit / 64] ^= std::uint64_t{1} << (bit % 64);
      }
    index.insert({kNobody, 1, n}, DescriptorKind::surf_bits, some);
  }
}

void measure_index(const char* name, const std::vector<View>& views, const Links& right, std::size_t budget_mb,
                   std::size_t features, std::size_t copies, bool simd = true) {
  PlaceIndexConfig config;
  config.budget_bytes = budget_mb << 20;
  config.simd = simd;
  PlaceIndex index(config);
  const double t0 = cpu_ms();
  fill(index, views, features);
  const double t1 = cpu_ms();
  add_copies(index, views, copies, features);
  const double t2 = cpu_ms();
  const auto rankings = ask(index, views, features);
  print(name, recall_of(rankings, right, cpu_ms() - t2));
  fmt::print("    {} keyframes, {} features, {} bits a table, insert {:.2f} ms, {} crowded out, {} refused\n",
             index.keyframes(), index.used(), index.table_bits(), (t1 - t0) / static_cast<double>(views.size()),
             index.crowded_out(), index.refused());
}

void measure_recall(const std::vector<View>& views, const Links& right, std::size_t copies) {
  fmt::print("\n{:44} {:>6} {:>7} {:>7} {:>7} {:>8}\n", "recall", "asked", "R@1", "R@10", "R@20", "ms each");
  double t = cpu_ms();
  auto rankings = all_pairs(views, 0.8f, &View::before);
  print("all pairs, int8, strongest 128, ratio 0.80", recall_of(rankings, right, cpu_ms() - t));
  for (const float ratio : {0.80f, 0.85f, 0.90f, 0.95f}) {
    t = cpu_ms();
    rankings = all_pairs(views, ratio, &View::now);
    print(fmt::format("all pairs, bits, strongest 128, ratio {:.2f}", ratio).c_str(),
          recall_of(rankings, right, cpu_ms() - t));
  }
  t = cpu_ms();
  rankings = exhaustive(views, 48);
  print("exhaustive, same votes", recall_of(rankings, right, cpu_ms() - t));
  measure_index("index", views, right, 32, 1000, 0);
  measure_index("index, plain", views, right, 32, 1000, 0, false);
  measure_index("index, strongest 256", views, right, 32, 256, 0);
  measure_index("index, 20 bits a table", views, right, 256, 1000, 0);
  if (copies > 0) {
    measure_index("index, 16 bits, with copies", views, right, 100, 1000, copies);
    measure_index("index, 20 bits, with copies", views, right, 256, 1000, copies);
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::string data = ONEMAP_SHARED_DIR "/data";
  bool links = true;
  std::size_t copies = 1800;
  for (int i = 1; i < argc; ++i) {
    if (!std::strcmp(argv[i], "--no-links"))
      links = false;
    else if (!std::strcmp(argv[i], "--copies") && i + 1 < argc)
      copies = static_cast<std::size_t>(std::max(1, std::atoi(argv[++i])));
    else
      data = argv[i];
  }
  if (data.starts_with('-')) {
    fmt::print(stderr, "usage: bench_place [DATA_FOLDER] [--no-links] [--copies N]\n");
    return 2;
  }
  std::vector<View> views;
  Costs costs;
  int chain = 0;
  for (const char* cut : {":0:263", ":263:526", ":526:789"}) add_chain(data + "/fr1_xyz", cut, chain++, views, costs);
  add_chain(data + "/fr1_rpy_a", "", chain++, views, costs);
  std::size_t bytes = 0, most = 0;
  for (const View& view : views) bytes += view.bytes, most = std::max(most, view.bytes);
  const double n = static_cast<double>(views.size());
  fmt::print("{} keyframes: {:.0f} bytes, at most {}; encode {:.2f} ms, decode {:.2f} ms, unpack {:.2f} ms\n\n", n,
             static_cast<double>(bytes) / n, most, costs.encode_ms / n, costs.decode_ms / n, costs.unpack_ms / n);
  fmt::print("{:34} {:>6} {:>6} {:>6} {:>8} {:>9} {:>7}\n", "links", "pairs", "right", "wrong", "inliers", "error mm",
             "ms each");
  const Links right = verify_all(views, {"bits, as in records", &View::now, 0.95f, 1});
  if (links) {
    verify_all(views, {"bits, another seed", &View::now, 0.95f, 2});
    verify_all(views, {"int8, lossless", &View::before, 0.9f, 1});
    verify_all(views, {"int8, lossless, another seed", &View::before, 0.9f, 2});
    verify_all(views, {"int8, grid of 80 x 60", &View::before_80, 0.9f, 1});
  }
  measure_recall(views, right, copies);
  return 0;
}
