#include "mapping/local/fundamental.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "local/ransac_sampling.hpp"

namespace onemap::mapping {

namespace {

using Points = std::span<const Eigen::Vector2d>;
using Vector9d = Eigen::Matrix<double, 9, 1>;
using Matrix9d = Eigen::Matrix<double, 9, 9>;

// Hartley's normalisation: x' = scale (x - centre), mean distance about sqrt(2). Not ok when the points lie on a line
// (or on one point): eq. (6) then says nothing.
struct Normalisation {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double scale = 1;
  bool ok = false;

  explicit Normalisation(Points x) {
    for (const auto& p : x) centre += p;
    centre /= static_cast<double>(x.size());
    double xx = 0, xy = 0, yy = 0;
    for (const auto& p : x) {
      const Eigen::Vector2d d = p - centre;
      xx += d.x() * d.x(), xy += d.x() * d.y(), yy += d.y() * d.y();
    }
    const double trace = xx + yy;
    scale = std::sqrt(2 * static_cast<double>(x.size()) / trace);
    ok = trace > 0 && xx * yy - xy * xy > 1e-10 * trace * trace;
  }
  Eigen::Vector2d operator()(const Eigen::Vector2d& p) const { return scale * (p - centre); }
  Matrix3d matrix() const {
    Matrix3d T;
    T << scale, 0, -scale * centre.x(), 0, scale, -scale * centre.y(), 0, 0, 1;
    return T;
  }
};

// One row of A f = 0 with f = F row by row: x_r^T F x_s.
Vector9d equation(const Eigen::Vector2d& r, const Eigen::Vector2d& s) {
  Vector9d a;
  a << r.x() * s.x(), r.x() * s.y(), r.x(), r.y() * s.x(), r.y() * s.y(), r.y(), s.x(), s.y(), 1;
  return a;
}

// A null vector of eight equations by Gaussian elimination with full pivoting. Where fewer than eight are independent
// (a camera that did not move, a plane) any member of the family will do.
Vector9d null_vector(Eigen::Matrix<double, 8, 9, Eigen::RowMajor>& A) {
  std::array<int, 9> column{0, 1, 2, 3, 4, 5, 6, 7, 8};
  int rank = 0;
  for (; rank < 8; ++rank) {
    int pivot_row = rank, pivot_col = rank;
    double largest = 0;
    for (int i = rank; i < 8; ++i) {
      for (int j = rank; j < 9; ++j) {
        const double a = std::abs(A(i, j));
        if (a > largest) largest = a, pivot_row = i, pivot_col = j;
      }
    }
    if (!(largest > 1e-9)) break;
    if (pivot_row != rank) A.row(rank).swap(A.row(pivot_row));
    if (pivot_col != rank) {
      A.col(rank).swap(A.col(pivot_col));
      std::swap(column[static_cast<std::size_t>(rank)], column[static_cast<std::size_t>(pivot_col)]);
    }
    const double inverse = 1 / A(rank, rank);
    for (int i = rank + 1; i < 8; ++i) {
      const double factor = A(i, rank) * inverse;
      for (int j = rank + 1; j < 9; ++j) A(i, j) -= factor * A(rank, j);
    }
  }
  Vector9d x = Vector9d::Zero();  // in pivot order; the first free unknown is 1, further ones 0
  x[rank] = 1;
  for (int i = rank - 1; i >= 0; --i) {
    double sum = 0;
    for (int j = i + 1; j <= rank; ++j) sum += A(i, j) * x[j];
    x[i] = -sum / A(i, i);
  }
  Vector9d f;
  for (std::size_t i = 0; i < 9; ++i) f[column[i]] = x[static_cast<Eigen::Index>(i)];
  return f;
}

// Rank 2: takes the part along the smallest singular value out.
Matrix3d with_rank_two(const Vector9d& f) {
  Matrix3d F;
  F << f[0], f[1], f[2], f[3], f[4], f[5], f[6], f[7], f[8];
  const Matrix3d FtF = F.transpose() * F;
  const Vector3d v = Eigen::SelfAdjointEigenSolver<Matrix3d>(FtF).eigenvectors().col(0);
  const Vector3d Fv = F * v;
  return F - Fv * v.transpose();
}

// First-order geometric (Sampson) distance, as numerator^2 and denominator^2.
bool is_inlier(const Matrix3d& F, const Eigen::Vector2d& r, const Eigen::Vector2d& s, double threshold2) {
  const double a = F(0, 0) * s.x() + F(0, 1) * s.y() + F(0, 2);
  const double b = F(1, 0) * s.x() + F(1, 1) * s.y() + F(1, 2);
  const double c = F(2, 0) * s.x() + F(2, 1) * s.y() + F(2, 2);
  const double d = F(0, 0) * r.x() + F(1, 0) * r.y() + F(2, 0);
  const double e = F(0, 1) * r.x() + F(1, 1) * r.y() + F(2, 1);
  const double error = r.x() * a + r.y() * b + c;
  return error * error <= threshold2 * (a * a + b * b + d * d + e * e);
}

int mark_inliers(const Matrix3d& F, Points r, Points s, double threshold2, std::size_t at_most_out,
                 std::span<std::uint8_t> inlier) {
  std::size_t out = 0;
  for (std::size_t i = 0; i < r.size(); ++i) {
    const bool in = is_inlier(F, r[i], s[i], threshold2);
    inlier[i] = in ? 1 : 0;
    out += in ? 0 : 1;
    if (out > at_most_out) return 0;
  }
  return static_cast<int>(r.size() - out);
}

// One problem: the matches and their normalisation.
class EightPoint {
 public:
  EightPoint(Points r, Points s)
      : r_(r), s_(s), norm_r_(r), norm_s_(s), to_r_(norm_r_.matrix().transpose()), to_s_(norm_s_.matrix()) {}
  bool ok() const { return norm_r_.ok && norm_s_.ok; }

  Matrix3d from_sample(const std::array<std::size_t, 8>& pick) const {
    Eigen::Matrix<double, 8, 9, Eigen::RowMajor> A;
    for (std::size_t i = 0; i < 8; ++i) {
      A.row(static_cast<Eigen::Index>(i)) = equation(norm_r_(r_[pick[i]]), norm_s_(s_[pick[i]])).transpose();
    }
    return denormalised(null_vector(A));
  }

  // Least squares over the inliers: the eigenvector of the smallest eigenvalue of A^T A.
  Matrix3d from_inliers(std::span<const std::uint8_t> use) const {
    Matrix9d AtA = Matrix9d::Zero();
    for (std::size_t i = 0; i < r_.size(); ++i) {
      if (!use[i]) continue;
      const Vector9d a = equation(norm_r_(r_[i]), norm_s_(s_[i]));
      AtA.noalias() += a * a.transpose();
    }
    return denormalised(Eigen::SelfAdjointEigenSolver<Matrix9d>(AtA).eigenvectors().col(0));
  }

 private:
  Matrix3d denormalised(const Vector9d& f) const {
    const Matrix3d F = to_r_ * with_rank_two(f) * to_s_;
    return F / std::sqrt(F.squaredNorm());
  }

  Points r_, s_;
  Normalisation norm_r_, norm_s_;
  Matrix3d to_r_, to_s_;
};

// The best matrix so far of one problem, with its inliers.
struct Search {
  const FundamentalConfig& config;
  const EightPoint& eight_point;
  Points r, s;
  std::span<std::uint8_t> candidate, inlier;
  Matrix3d& F;
  int best = 0;

  int least() const { return std::max(8, config.min_inliers); }
  bool all_in() const { return best == static_cast<int>(r.size()); }

  // Takes G when it has at least so many inliers.
  bool accept(const Matrix3d& G, int at_least) {
    const std::size_t at_most_out = r.size() - static_cast<std::size_t>(at_least);
    const int count = mark_inliers(G, r, s, config.threshold * config.threshold, at_most_out, candidate);
    if (count < at_least) return false;
    best = count;
    F = G;
    std::copy(candidate.begin(), candidate.end(), inlier.begin());
    return true;
  }

  // Samples of eight until one without outliers is likely among them.
  void sample_eights(int& iterations) {
    SplitMix random(config.seed);
    for (int needed = config.max_iterations; iterations < needed && !all_in();) {
      ++iterations;
      if (!accept(eight_point.from_sample(sample<8>(random, r.size())), best + 1)) continue;
      // A sample of eight noisy points is a poor fit even without outliers: improve it before it is judged.
      for (int k = 0; k < 3 && best >= 12 && !all_in(); ++k)
        if (!accept(eight_point.from_inliers(inlier), best + 1)) break;
      needed = ransac_iterations(static_cast<double>(best) / static_cast<double>(r.size()), 8, config.confidence,
                                 config.max_iterations);
    }
  }
};

}  // namespace

FundamentalRansac::FundamentalRansac(const FundamentalConfig& config, std::size_t max_matches)
    : config_(config), candidate_(max_matches) {}

RansacResult FundamentalRansac::estimate(Points r, Points s, std::span<std::uint8_t> inlier, Matrix3d& F) {
  assert(r.size() == s.size() && inlier.size() >= r.size() && r.size() <= candidate_.size());
  const std::size_t n = r.size();
  RansacResult result;
  inlier = inlier.first(n);
  std::fill(inlier.begin(), inlier.end(), std::uint8_t{0});
  if (n < static_cast<std::size_t>(std::max(8, config_.min_inliers))) return result;
  const EightPoint eight_point(r, s);
  result.reason = RansacReason::degenerate;
  if (!eight_point.ok()) return result;
  Search search{config_, eight_point, r, s, {candidate_.data(), n}, inlier, F};
  search.sample_eights(result.iterations);
  result.inliers = search.best;
  result.reason = RansacReason::too_few_inliers;
  if (search.best < search.least()) return result;
  search.accept(eight_point.from_inliers(inlier), search.best);
  result.inliers = search.best;
  result.reason = RansacReason::ok;
  return result;
}

}  // namespace onemap::mapping
