#pragma once
#include <array>
#include <cmath>
#include <cstddef>

namespace onemap::hal::imaging {

// Normal equations of a few unknowns: sums of J J^T and J r, solved by Cholesky's decomposition.
template <std::size_t N>
struct NormalEquations {
  std::array<std::array<double, N>, N> A{};  // the lower triangle
  std::array<double, N> b{};
  double squares = 0;  // of the residuals
  double weight = 0;

  void add(const std::array<double, N>& J, double r, double w = 1) {
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t j = 0; j <= i; ++j) A[i][j] += w * J[i] * J[j];
      b[i] += w * J[i] * r;
    }
    squares += w * r * r;
    weight += w;
  }

  void add(const NormalEquations& other) {
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t j = 0; j <= i; ++j) A[i][j] += other.A[i][j];
      b[i] += other.b[i];
    }
    squares += other.squares;
    weight += other.weight;
  }

  // x with A x = right; false: the equations do not say all of it.
  bool solve(const std::array<double, N>& right, std::array<double, N>& x) const {
    std::array<std::array<double, N>, N> L{};
    for (std::size_t i = 0; i < N; ++i)
      for (std::size_t j = 0; j <= i; ++j) {
        double sum = A[i][j];
        for (std::size_t k = 0; k < j; ++k) sum -= L[i][k] * L[j][k];
        if (i == j && !(sum > 1e-12 * A[i][i])) return false;
        L[i][j] = i == j ? std::sqrt(sum) : sum / L[j][j];
      }
    for (std::size_t i = 0; i < N; ++i) {
      x[i] = right[i];
      for (std::size_t k = 0; k < i; ++k) x[i] -= L[i][k] * x[k];
      x[i] /= L[i][i];
    }
    for (std::size_t i = N; i-- > 0;) {
      for (std::size_t k = i + 1; k < N; ++k) x[i] -= L[k][i] * x[k];
      x[i] /= L[i][i];
    }
    return true;
  }
  bool solve(std::array<double, N>& x) const { return solve(b, x); }

  // The sum of squared residuals that a solution leaves.
  double left(const std::array<double, N>& x) const {
    double sum = squares;
    for (std::size_t i = 0; i < N; ++i) {
      sum -= 2 * x[i] * b[i];
      for (std::size_t j = 0; j < N; ++j) sum += x[i] * x[j] * (i >= j ? A[i][j] : A[j][i]);
    }
    return sum;
  }
};

}  // namespace onemap::hal::imaging
