// SURF against its peers on a recording, one core: time, repeatability, mutual matches, inliers of a fundamental matrix
// (the same estimator for all: OpenCV's RANSAC, 1 px, undistorted points) and true matches by the recorded truth.
//   bench_surf [FOLDER of a TUM recording] [every Nth frame starts a pair, 15] [only detectors with this in their name]
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <functional>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "mapping/geometry.hpp"
#include "mapping/local/match.hpp"
#include "mapping/local/orb.hpp"
#include "mapping/local/surf.hpp"
#include "support/text_of.hpp"
#ifdef ONEMAP_HAVE_DLIB
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wnon-virtual-dtor"
#include <dlib/image_keypoint.h>
#include <dlib/opencv.h>
#pragma GCC diagnostic pop
#endif

namespace {

using namespace onemap;
using namespace onemap::mapping;
namespace fs = std::filesystem;

struct TimedPose {
  double time = 0;
  Eigen::Vector3d t;
  Eigen::Quaterniond q;
};

struct Frame {
  double time = 0;
  std::string colour, depth;
};

struct Recording {
  std::vector<Frame> frames;
  std::vector<TimedPose> truth;
  std::map<std::string, double> calibration;
  cv::Mat K, distortion;
};

std::vector<std::vector<std::string>> rows(const fs::path& file) {
  std::vector<std::vector<std::string>> out;
  for (const std::string& line : onemap::test::lines_of(file)) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    out.emplace_back(std::istream_iterator<std::string>(words), std::istream_iterator<std::string>());
  }
  return out;
}

Recording load(const fs::path& folder) {
  Recording r;
  for (const auto& w : rows(folder / "associations.txt"))
    r.frames.push_back({std::stod(w.at(0)), (folder / w.at(1)).string(), (folder / w.at(3)).string()});
  for (const auto& w : rows(folder / "groundtruth.txt")) {
    const auto v = [&](std::size_t i) { return std::stod(w.at(i)); };
    r.truth.push_back({v(0), {v(1), v(2), v(3)}, Eigen::Quaterniond(v(7), v(4), v(5), v(6))});
  }
  for (const auto& w : rows(folder / "calibration.txt")) r.calibration[w.at(0)] = std::stod(w.at(1));
  auto& c = r.calibration;
  r.K = (cv::Mat_<double>(3, 3) << c["fx"], 0, c["cx"], 0, c["fy"], c["cy"], 0, 0, 1);
  r.distortion = (cv::Mat_<double>(1, 5) << c["k1"], c["k2"], c["p1"], c["p2"], c["k3"]);
  return r;
}

Eigen::Isometry3d pose_at(const Recording& r, double time) {
  auto next =
      std::lower_bound(r.truth.begin(), r.truth.end(), time, [](const TimedPose& p, double t) { return p.time < t; });
  next = std::clamp(next, r.truth.begin() + 1, r.truth.end() - 1);
  const TimedPose &a = *(next - 1), &b = *next;
  const double u = std::clamp((time - a.time) / (b.time - a.time), 0.0, 1.0);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = a.q.slerp(u, b.q).normalized().toRotationMatrix();
  T.translation() = a.t + u * (b.t - a.t);
  return T;
}

struct Features {
  FeatureSet set;
  std::vector<cv::Point2f> undistorted;  // pixels
};

struct Detector {
  std::string name;
  std::function<void(const cv::Mat&, FeatureSet&)> detect;
  std::map<std::size_t, Features> found = {};
  std::vector<double> ms = {};
};

// CPU time of this program, which has one thread: other programs on the machine do not count.
double cpu_ms() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

double percentile(std::vector<double> v, double p) {
  if (v.empty()) return 0;
  const auto k = static_cast<std::ptrdiff_t>(p * static_cast<double>(v.size() - 1) + 0.5);
  std::nth_element(v.begin(), v.begin() + k, v.end());
  return v[static_cast<std::size_t>(k)];
}

const Features& features(Detector& d, const Recording& r, std::size_t index, const cv::Mat& grey) {
  const auto [it, fresh] = d.found.try_emplace(index);
  Features& f = it->second;
  if (!fresh) return f;
  f.set.reserve(2000);
  const double start = cpu_ms();
  d.detect(grey, f.set);
  d.ms.push_back(cpu_ms() - start);
  std::vector<cv::Point2f> points;
  for (const Keypoint& k : f.set.keypoints) points.emplace_back(k.x_px, k.y_px);
  if (!points.empty()) cv::undistortPoints(points, f.undistorted, r.K, r.distortion, cv::noArray(), r.K);
  return f;
}

// Where the points of frame i are seen in frame j by depth and truth (undistorted pixels); NaN where not known.
std::vector<cv::Point2f> project(const Recording& r, const Features& f, std::size_t i, std::size_t j) {
  const cv::Mat depth = cv::imread(r.frames[i].depth, cv::IMREAD_UNCHANGED);
  const Eigen::Isometry3d T = pose_at(r, r.frames[j].time).inverse() * pose_at(r, r.frames[i].time);
  const double fx = r.K.at<double>(0, 0), fy = r.K.at<double>(1, 1), cx = r.K.at<double>(0, 2),
               cy = r.K.at<double>(1, 2);
  std::vector<cv::Point2f> out;
  for (std::size_t k = 0; k < f.set.size(); ++k) {
    const cv::Point pixel(cvRound(f.set.keypoints[k].x_px), cvRound(f.set.keypoints[k].y_px));
    const std::uint16_t raw =
        cv::Rect(0, 0, depth.cols, depth.rows).contains(pixel) ? depth.at<std::uint16_t>(pixel) : 0;
    const double z = raw / r.calibration.at("depth_scale");
    const cv::Point2f& u = f.undistorted[k];
    const Eigen::Vector3d p = T * Eigen::Vector3d((u.x - cx) / fx * z, (u.y - cy) / fy * z, z);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    if (raw == 0 || p.z() < 0.1) {
      out.emplace_back(nan, nan);
    } else {
      out.emplace_back(static_cast<float>(fx * p.x() / p.z() + cx), static_cast<float>(fy * p.y() / p.z() + cy));
    }
  }
  return out;
}

struct PairScores {
  std::vector<double> matches, inliers, truths, share, repeatability, match_ms;
};

void score(const Recording& r, const Features& a, const Features& b, std::size_t i, std::size_t j, PairScores& out) {
  static Matcher matcher({.cross_check = true, .max_ratio = 1.f}, 2000);
  const double start = cpu_ms();
  const auto matches = matcher.match(a.set, b.set);
  out.match_ms.push_back(cpu_ms() - start);
  const auto projected = project(r, a, i, j);
  std::vector<cv::Point2f> pa, pb;
  int known = 0, truths = 0;
  for (const Match& m : matches) {
    pa.push_back(a.undistorted[m.a]);
    pb.push_back(b.undistorted[m.b]);
    if (!(projected[m.a].x == projected[m.a].x)) continue;
    ++known;
    truths += cv::norm(projected[m.a] - pb.back()) < 6 ? 1 : 0;
  }
  cv::Mat mask;
  int inliers = 0;
  if (pa.size() >= 8 && !cv::findFundamentalMat(pa, pb, cv::FM_RANSAC, 1.0, 0.999, 2000, mask).empty())
    inliers = cv::countNonZero(mask);
  int visible = 0, repeated = 0;
  for (const cv::Point2f& p : projected) {
    if (!(p.x > 20 && p.y > 20 && p.x < 620 && p.y < 460)) continue;
    ++visible;
    repeated += std::any_of(b.undistorted.begin(), b.undistorted.end(),
                            [&](const cv::Point2f& q) { return cv::norm(p - q) < 3; })
                    ? 1
                    : 0;
  }
  out.matches.push_back(static_cast<double>(matches.size()));
  out.inliers.push_back(inliers);
  out.truths.push_back(truths);
  out.share.push_back(known > 0 ? 100.0 * truths / known : 0);
  out.repeatability.push_back(visible > 0 ? 100.0 * repeated / visible : 0);
}

std::vector<Detector> detectors() {
  const auto view = [](const cv::Mat& m) { return GrayView{m.data, m.cols, m.rows, static_cast<int>(m.step)}; };
  std::vector<Detector> out;
  const auto add_surf = [&](const std::string& name, const SurfConfig& config) {
    auto surf = std::make_shared<Surf>(config, 640, 480);
    out.push_back({name, [surf, view](const cv::Mat& m, FeatureSet& f) { surf->detect(view(m), f); }});
  };
  add_surf("onemap SURF", {});
  add_surf("onemap SURF upright", {.upright = true});
  add_surf("onemap SURF plain", {.simd = false});
  auto orb = std::make_shared<Orb>(OrbConfig{}, 640, 480);
  out.push_back({"OpenCV ORB", [orb, view](const cv::Mat& m, FeatureSet& f) { orb->detect(view(m), f); }});
#ifdef ONEMAP_HAVE_DLIB
  out.push_back({"dlib SURF", [](const cv::Mat& m, FeatureSet& f) {
                   const auto points = dlib::get_surf_points(dlib::cv_image<unsigned char>(m), 500, 30.0);
                   for (const auto& p : points) {
                     f.keypoints.push_back({static_cast<float>(p.p.center.x()), static_cast<float>(p.p.center.y()),
                                            static_cast<float>(20 * p.p.scale), 1, 0, static_cast<float>(p.p.score),
                                            static_cast<std::int8_t>(p.p.laplacian)});
                     auto& v = f.descriptors.emplace_back().v;
                     for (long k = 0; k < 64; ++k)
                       v[static_cast<std::size_t>(k)] = static_cast<std::int8_t>(std::lround(127 * p.des(k)));
                   }
                 }});
#endif
  return out;
}

void print(const Detector& d, const std::map<std::size_t, PairScores>& by_gap) {
  std::vector<double> counts;
  for (const auto& [index, f] : d.found) counts.push_back(static_cast<double>(f.set.size()));
  fmt::print("{:<20} {:6.2f} {:6.2f}  {:4.0f} {:4.0f}", d.name, percentile(d.ms, 0.5), percentile(d.ms, 0.95),
             percentile(counts, 0.5), percentile(counts, 0.0));
  for (const auto& [gap, s] : by_gap)
    fmt::print(" | {:5.2f} {:4.0f}  {:4.0f} ({:3.0f})  {:4.0f} ({:3.0f}) {:3.0f}%  {:3.0f}%",
               percentile(s.match_ms, 0.5), percentile(s.matches, 0.5), percentile(s.inliers, 0.5),
               percentile(s.inliers, 0.1), percentile(s.truths, 0.5), percentile(s.truths, 0.1),
               percentile(s.share, 0.5), percentile(s.repeatability, 0.5));
  fmt::print("\n");
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(0);
  const fs::path folder = argc > 1 ? argv[1] : ONEMAP_SHARED_DIR "/data/fr1_xyz";
  const std::size_t every = argc > 2 ? std::stoul(argv[2]) : 15;
  const Recording r = load(folder);
  if (r.frames.size() < 40 || r.truth.size() < 2) {
    fmt::print("bench_surf: {} has no recording with associations.txt and groundtruth.txt\n", folder.string());
    return 1;
  }
  auto all = detectors();
  if (argc > 3) std::erase_if(all, [&](const Detector& d) { return d.name.find(argv[3]) == std::string::npos; });
  std::vector<std::map<std::size_t, PairScores>> scores(all.size());
  for (std::size_t i = 0; i + 30 < r.frames.size(); i += every) {
    for (const std::size_t j : {i, i + 10, i + 30}) {
      const cv::Mat grey = cv::imread(r.frames[j].colour, cv::IMREAD_GRAYSCALE);
      for (Detector& d : all) features(d, r, j, grey);
    }
    for (std::size_t k = 0; k < all.size(); ++k)
      for (const std::size_t gap : {std::size_t{10}, std::size_t{30}})
        score(r, all[k].found.at(i), all[k].found.at(i + gap), i, i + gap, scores[k][gap]);
  }
  fmt::print("{}, a pair every {} frames; medians (10th percentile); gaps of 10 and of 30 frames\n", folder.string(),
             every);
  fmt::print("{:<20} {:>6} {:>6}  {:>4} {:>4}", "", "ms", "p95", "kpts", "min");
  for (int gap = 0; gap < 2; ++gap)
    fmt::print(" | {:>5} {:>4}  {:>10}  {:>15}  {}", "match", "mnn", "F inliers", "true", "repeat");
  fmt::print("\n");
  for (std::size_t k = 0; k < all.size(); ++k) print(all[k], scores[k]);
  return 0;
}
