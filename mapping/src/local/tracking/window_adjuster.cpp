#include "window_adjuster.hpp"

#include <algorithm>
#include <cmath>

namespace onemap::mapping {

namespace {

constexpr int kWindowIterations = 4;
constexpr double kNearest_m = 0.02;
constexpr int N = 6 * static_cast<int>(kWindow);

// Solves S x = b for the leading n rows by Cholesky, in a fixed order of operations; false when S is not positive
// definite.
bool cholesky_solve(Eigen::Matrix<double, N, N>& S, Eigen::Matrix<double, N, 1>& x, int n) {
  for (int j = 0; j < n; ++j) {
    double d = S(j, j);
    for (int k = 0; k < j; ++k) d -= S(j, k) * S(j, k);
    if (!(d > 1e-12)) return false;
    S(j, j) = std::sqrt(d);
    for (int i = j + 1; i < n; ++i) {
      double s = S(i, j);
      for (int k = 0; k < j; ++k) s -= S(i, k) * S(j, k);
      S(i, j) = s / S(j, j);
    }
  }
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < i; ++k) x[i] -= S(i, k) * x[k];
    x[i] /= S(i, i);
  }
  for (int i = n - 1; i >= 0; --i) {
    for (int k = i + 1; k < n; ++k) x[i] -= S(k, i) * x[k];
    x[i] /= S(i, i);
  }
  return true;
}

}  // namespace

WindowAdjuster::WindowAdjuster(std::size_t max_landmarks, std::size_t max_observations) {
  points_.reserve(max_landmarks);
  trial_.reserve(max_landmarks);
  step_b_.reserve(max_landmarks);
  inverse_V_.reserve(max_landmarks);
  gathered_.reserve(max_observations);
  observations_.reserve(max_observations);
  point_of_.reserve(max_observations);
  W_.reserve(max_observations);
}

std::size_t WindowAdjuster::bytes() const {
  return sizeof(*this) + points_.capacity() * (sizeof(Point) + 2 * sizeof(Vector3d) + sizeof(Matrix3d)) +
         W_.capacity() * (2 * sizeof(Obs) + sizeof(std::uint32_t) + sizeof(Matrix36));
}

const Pose& WindowAdjuster::pose_of(std::int32_t index, const std::array<Pose, kWindow>& poses) const {
  const auto i = static_cast<std::size_t>(index);
  return i < kWindow ? poses[i] : fixed_pose_[i - kWindow];
}

void WindowAdjuster::add_observations(LandmarkMap& map, std::size_t slot, std::int32_t pose, bool create) {
  const MapKeyframe& k = map.keyframe(slot);
  for (std::size_t i = 0; i < k.features.size(); ++i) {
    const std::int32_t id = k.features.landmark[i];
    if (id < 0 || map.landmark(id).observations < 2) continue;
    Landmark& l = map.landmark(id);
    if (l.slot < 0) {
      if (!create || points_.size() == points_.capacity()) continue;
      l.slot = static_cast<std::int32_t>(points_.size());
      points_.push_back({l.p_robot, id, 0, 0});
    }
    if (gathered_.size() == gathered_.capacity()) return;
    gathered_.push_back({{k.features.ray[i], k.features.inverse_depth(i), weight_of(k.features.set.keypoints[i])},
                         pose,
                         static_cast<std::uint32_t>(i)});
    point_of_.push_back(static_cast<std::uint32_t>(l.slot));
  }
}

// Collects points and observations and sorts the observations by point (stable).
void WindowAdjuster::gather(LandmarkMap& map, std::span<const std::size_t> free_slots) {
  points_.clear();
  gathered_.clear();
  point_of_.clear();
  const std::uint32_t mark = map.next_mark();
  gather_free(map, free_slots, mark);
  gather_fixed(map, mark);
  first_is_fixed_ = fixed_ == 0;
  sort_by_point();
}

// The window's keyframes, and their landmarks as the points.
void WindowAdjuster::gather_free(LandmarkMap& map, std::span<const std::size_t> free_slots, std::uint32_t mark) {
  for (const std::size_t slot : free_slots)
    for (const std::int32_t id : map.keyframe(slot).features.landmark)
      if (id >= 0) map.landmark(id).mark = mark, map.landmark(id).slot = -1;
  free_ = 0;
  for (const std::size_t slot : free_slots) {
    pose_[free_] = map.keyframe(slot).T_camera_robot;
    free_slot_[free_] = slot;
    depth_[free_] = map.keyframe(slot).depth;
    add_observations(map, slot, static_cast<std::int32_t>(free_), true);
    ++free_;
  }
}

// Other keyframes that see the points.
void WindowAdjuster::gather_fixed(LandmarkMap& map, std::uint32_t mark) {
  fixed_ = 0;
  const std::span<const std::size_t> free_slots(free_slot_.data(), free_);
  std::array<std::size_t, kWindow + kFixedMost> near{};
  const std::size_t n = map.covisible(mark, 10, near);
  for (std::size_t i = 0; i < n && fixed_ < kFixedMost; ++i) {
    if (std::find(free_slots.begin(), free_slots.end(), near[i]) != free_slots.end()) continue;
    // Landmarks outside the window keep stale scratch slots; their mark tells them apart.
    fixed_pose_[fixed_] = map.keyframe(near[i]).T_camera_robot;
    fixed_slot_[fixed_] = near[i];
    const std::size_t before = gathered_.size();
    for (const std::int32_t id : map.keyframe(near[i]).features.landmark)
      if (id >= 0 && map.landmark(id).mark != mark) map.landmark(id).slot = -1;
    add_observations(map, near[i], static_cast<std::int32_t>(kWindow + fixed_), false);
    if (gathered_.size() > before) ++fixed_;
  }
}

void WindowAdjuster::sort_by_point() {
  for (Point& p : points_) p.begin = p.end = 0;
  for (const std::uint32_t p : point_of_) ++points_[p].end;
  std::uint32_t at = 0;
  for (Point& p : points_) {
    const std::uint32_t count = p.end;
    p.begin = p.end = at;
    at += count;
  }
  observations_.resize(gathered_.size());
  for (std::size_t i = 0; i < gathered_.size(); ++i) observations_[points_[point_of_[i]].end++] = gathered_[i];
}

double WindowAdjuster::cost(double focal_px, const std::array<Pose, kWindow>& poses, bool trial) const {
  double sum = 0;
  for (std::size_t i = 0; i < free_; ++i) {
    if (!depth_[i]) continue;
    const Vector6d off = motion_between(depth_[i]->T_camera_robot, poses[i]);
    sum += off.dot(depth_[i]->information * off);
  }
  for (std::size_t j = 0; j < points_.size(); ++j)
    for (std::uint32_t k = points_[j].begin; k < points_[j].end; ++k) {
      const Obs& obs = observations_[k];
      const Vector3d p = pose_of(obs.pose, poses) * (trial ? trial_[j] : points_[j].p);
      if (p.z() < kNearest_m) {
        sum += 1e4;
        continue;
      }
      const double chi2 = obs.o.weight * residual(p, obs.o, focal_px).squaredNorm(), bound = chi2_bound(obs.o);
      sum += chi2 <= bound ? chi2 : 2 * std::sqrt(chi2 * bound) - bound;
    }
  return sum;
}

// Builds the reduced system S delta = g over the free poses: U - sum_j W_j V_j^-1 W_j^T.
void WindowAdjuster::linearize(double focal_px, double lambda) {
  S_.setZero();
  g_.setZero();
  W_.resize(observations_.size());
  inverse_V_.resize(points_.size());
  step_b_.resize(points_.size());
  for (std::size_t j = 0; j < points_.size(); ++j) {
    Matrix3d V = linearize_point(j, focal_px);
    for (int d = 0; d < 3; ++d) V(d, d) += lambda * V(d, d) + 1e-9;
    inverse_V_[j] = V.inverse();
    eliminate_point(j);
  }
  hold_by_depth();
  for (int d = 0; d < N; ++d) S_(d, d) += lambda * std::abs(S_(d, d)) + 1e-9;
  if (first_is_fixed_)
    for (int d = 0; d < 6; ++d) S_(d, d) = 1, g_[d] = 0;
}

// Keyframes that depth has placed stay near to where it says: their landmarks are few.
void WindowAdjuster::hold_by_depth() {
  for (std::size_t i = first_is_fixed_ ? 1 : 0; i < free_; ++i) {
    if (!depth_[i]) continue;
    const int at = 6 * static_cast<int>(i);
    S_.block<6, 6>(at, at) += depth_[i]->information;
    g_.segment<6>(at) -= depth_[i]->information * motion_between(depth_[i]->T_camera_robot, pose_[i]);
  }
}

// The point's observations: their part of U and g, W, the point's own gradient b; returns its V.
Matrix3d WindowAdjuster::linearize_point(std::size_t j, double focal_px) {
  Matrix3d V = Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
  for (std::uint32_t k = points_[j].begin; k < points_[j].end; ++k) {
    const Obs& obs = observations_[k];
    const Pose& T = pose_of(obs.pose, pose_);
    const Vector3d p = T * points_[j].p;
    W_[k].setZero();
    if (p.z() < kNearest_m) continue;
    const Vector3d r = residual(p, obs.o, focal_px);
    const double w = obs.o.weight * huber_weight(obs.o.weight * r.squaredNorm(), chi2_bound(obs.o));
    const Matrix3d Jq = residual_by_point(p, obs.o, focal_px);
    const Matrix3d Jp = Jq * T.R;
    V.noalias() += w * Jp.transpose() * Jp;
    b.noalias() += w * Jp.transpose() * r;
    const bool moves = obs.pose < static_cast<std::int32_t>(kWindow) && !(first_is_fixed_ && obs.pose == 0);
    if (!moves) continue;
    const Eigen::Matrix<double, 3, 6> Jc = Jq * point_by_motion(p);
    const int at = 6 * obs.pose;
    S_.block<6, 6>(at, at).noalias() += w * Jc.transpose() * Jc;
    g_.segment<6>(at).noalias() -= w * Jc.transpose() * r;
    W_[k].noalias() = w * Jp.transpose() * Jc;
  }
  step_b_[j] = b;
  return V;
}

// The Schur complement: the point leaves the system.
void WindowAdjuster::eliminate_point(std::size_t j) {
  const Matrix3d inverse = inverse_V_[j];
  const Vector3d b = step_b_[j];
  for (std::uint32_t k = points_[j].begin; k < points_[j].end; ++k) {
    if (observations_[k].pose >= static_cast<std::int32_t>(kWindow)) continue;
    const int at = 6 * observations_[k].pose;
    const Eigen::Matrix<double, 6, 3> WV = W_[k].transpose() * inverse;
    g_.segment<6>(at).noalias() += WV * b;
    for (std::uint32_t m = points_[j].begin; m < points_[j].end; ++m) {
      const int to = 6 * observations_[m].pose;
      if (observations_[m].pose >= static_cast<std::int32_t>(kWindow) || to > at) continue;
      S_.block<6, 6>(at, to).noalias() -= WV * W_[m];
    }
  }
}

bool WindowAdjuster::solve() {
  delta_ = g_;
  if (!cholesky_solve(S_, delta_, 6 * static_cast<int>(free_))) return false;
  for (std::size_t i = 0; i < free_; ++i) {
    const Vector6d d = delta_.segment<6>(6 * static_cast<int>(i));
    trial_pose_[i] = small_motion(d) * pose_[i];
    trial_pose_[i].R = orthonormal(trial_pose_[i].R);
  }
  trial_.resize(points_.size());
  for (std::size_t j = 0; j < points_.size(); ++j) {
    Vector3d b = step_b_[j];
    for (std::uint32_t k = points_[j].begin; k < points_[j].end; ++k)
      if (observations_[k].pose < static_cast<std::int32_t>(kWindow))
        b.noalias() += W_[k] * delta_.segment<6>(6 * observations_[k].pose);
    trial_[j] = points_[j].p - inverse_V_[j] * b;
  }
  return true;
}

void WindowAdjuster::drop_outliers(LandmarkMap& map, double focal_px) {
  for (const Point& point : points_)
    for (std::uint32_t k = point.begin; k < point.end; ++k) {
      const Obs& obs = observations_[k];
      const Vector3d p = pose_of(obs.pose, pose_) * point.p;
      const bool fits =
          p.z() > kNearest_m && obs.o.weight * residual(p, obs.o, focal_px).squaredNorm() <= 1.5 * chi2_bound(obs.o);
      if (fits || obs.pose >= static_cast<std::int32_t>(kWindow)) continue;
      map.unlink(map.keyframe(free_slot_[static_cast<std::size_t>(obs.pose)]), obs.feature);
    }
}

void WindowAdjuster::adjust(LandmarkMap& map, std::span<const std::size_t> free_slots, double focal_px) {
  gather(map, free_slots);
  if (points_.size() < 10) return;
  double lambda = 1e-4, current = cost(focal_px, pose_, false);
  for (int i = 0; i < kWindowIterations; ++i) {
    linearize(focal_px, lambda);
    if (!solve()) {
      lambda *= 10;
      continue;
    }
    const double next = cost(focal_px, trial_pose_, true);
    if (!(next < current)) {
      lambda *= 10;
      continue;
    }
    const bool done = current - next < 1e-3 * current;
    current = next;
    pose_ = trial_pose_;
    for (std::size_t j = 0; j < points_.size(); ++j) points_[j].p = trial_[j];
    lambda *= 0.3;
    if (done) break;
  }
  for (std::size_t i = 0; i < free_; ++i) map.keyframe(free_slot_[i]).T_camera_robot = pose_[i];
  for (const Point& point : points_) map.landmark(point.id).p_robot = point.p;
  drop_outliers(map, focal_px);
}

}  // namespace onemap::mapping
