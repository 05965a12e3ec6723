// The equations of a pose graph against Eigen's dense algebra.
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "poses.hpp"
#include "random.hpp"
#include "team/pose_graph/block_cholesky.hpp"
#include "team/pose_graph/conjugate_gradients.hpp"
#include "team/pose_graph/least_squares.hpp"

namespace onemap::mapping {
namespace {

Eigen::Index at(std::size_t block) { return static_cast<Eigen::Index>(6 * block); }

Eigen::VectorXd some_vector(std::size_t blocks, test::Random& random) {
  Eigen::VectorXd out(at(blocks));
  for (double& x : out) x = random.uniform(-1, 1);
  return out;
}

// Chains of ten and as many other places as asked for: what a graph's edges sum up to.
BlockMatrix some_matrix(std::size_t size, int others, test::Random& random) {
  std::vector<BlockMatrix::Place> places;
  for (std::size_t i = 1; i < size; ++i)
    if (i % 10 != 0) places.emplace_back(i - 1, i);
  for (int i = 0; i < others; ++i)
    places.emplace_back(random.integer(0, static_cast<int>(size) - 1), random.integer(0, static_cast<int>(size) - 1));
  BlockMatrix H(size, places);
  for (std::size_t i = 0; i < size; ++i) H.diagonal[i].setIdentity();
  for (std::size_t j = 0; j < size; ++j)
    for (std::size_t k = H.first[j]; k < H.first[j + 1]; ++k) {
      Eigen::Matrix<double, 6, 12> J;
      for (double& x : J.reshaped()) x = random.uniform(-1, 1);
      J.rightCols<6>() += J.leftCols<6>();  // nearly what moves both
      H.diagonal[j] += J.leftCols<6>().transpose() * J.leftCols<6>();
      H.diagonal[H.row[k]] += J.rightCols<6>().transpose() * J.rightCols<6>();
      H.below[k] += J.rightCols<6>().transpose() * J.leftCols<6>();
    }
  return H;
}

Eigen::MatrixXd dense(const BlockMatrix& H) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(at(H.size()), at(H.size()));
  for (std::size_t j = 0; j < H.size(); ++j) {
    out.block<6, 6>(at(j), at(j)) = H.diagonal[j];
    for (std::size_t k = H.first[j]; k < H.first[j + 1]; ++k) {
      out.block<6, 6>(at(H.row[k]), at(j)) = H.below[k];
      out.block<6, 6>(at(j), at(H.row[k])) = H.below[k].transpose();
    }
  }
  return out;
}

TEST(PoseGraphEquations, AFactorSolvesThemAndKnowsTheInverse) {
  test::Random random(1);
  for (int others : {0, 5, 40, 400}) {
    const BlockMatrix H = some_matrix(40, others, random);
    Eigen::MatrixXd full = dense(H);
    const Eigen::VectorXd b = some_vector(40, random);
    EXPECT_LT((H.times(b) - full * b).norm(), 1e-10);
    full.diagonal() *= 1.5;
    auto factor = BlockCholesky::of(H, 1'000'000);
    ASSERT_TRUE(factor);
    for (int again = 0; again < 2; ++again) ASSERT_TRUE(factor->factor(H, 0.5));
    EXPECT_LT((full * factor->solve(b) - b).norm(), 1e-9) << others;
    const Matrix6d at_3 = Matrix6d::Random(), at_30 = Matrix6d::Random();
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(at(40), 6);
    J.middleRows<6>(at(3)) = at_3;
    J.middleRows<6>(at(30)) = at_30;
    const Matrix6d inverse = J.transpose() * full.inverse() * J;
    EXPECT_LT((factor->inverse_between({{3, at_3}, {30, at_30}}) - inverse).norm(), 1e-9 * inverse.norm());
  }
}

TEST(PoseGraphEquations, WhatIsNotPositiveDefiniteIsSaid) {
  test::Random random(2);
  BlockMatrix H = some_matrix(20, 10, random);
  H.diagonal[7](2, 2) = -1;
  EXPECT_FALSE(BlockCholesky::of(H, 1'000'000)->factor(H, 0));
  EXPECT_FALSE(ConjugateGradients(H).prepare(H, 0));
}

TEST(PoseGraphEquations, AFactorThatCostsTooMuchIsNotBegun) {
  test::Random random(3);
  const BlockMatrix sparse = some_matrix(60, 0, random), full = some_matrix(60, 2000, random);
  EXPECT_LT(BlockCholesky::of(sparse, 1'000'000)->products(), 200u);
  const std::size_t products = BlockCholesky::of(full, 1'000'000)->products();
  EXPECT_GT(products, 5'000u);
  EXPECT_TRUE(BlockCholesky::of(full, products));
  EXPECT_FALSE(BlockCholesky::of(full, products - 1));
}

TEST(PoseGraphEquations, ConjugateGradientsComeToTheSame) {
  test::Random random(4);
  for (int others : {0, 60, 400}) {
    const BlockMatrix H = some_matrix(40, others, random);
    Eigen::MatrixXd full = dense(H);
    full.diagonal() *= 1.1;
    ConjugateGradients gradients(H);
    ASSERT_TRUE(gradients.prepare(H, 0.1));
    const Eigen::VectorXd b = some_vector(40, random);
    const auto answer = gradients.solve(b);
    ASSERT_TRUE(answer.converged);
    const Eigen::VectorXd exact = full.llt().solve(b);
    EXPECT_LT((answer.x - exact).norm(), 0.01 * exact.norm()) << others;
    if (others == 0) {
      EXPECT_LT((answer.x - exact).norm(), 1e-9 * exact.norm()) << "chains alone are solved at once";
    }
  }
}

// A thicket of links, whose equations have no factor, and truth.
TEST(PoseGraphEquations, LeastSquaresWithoutAFactorFindTruth) {
  test::Random random(5);
  std::vector<Pose> truth;
  for (int i = 0; i < 120; ++i) truth.push_back(test::random_pose(random, 3, 5));
  PoseProblem problem{.poses = truth};
  const auto edge = [&](std::size_t a, std::size_t b) {
    return GraphEdge{a, b, truth[a].inverse() * truth[b], information_of(0.01, 0.02)};
  };
  for (std::size_t i = 1; i < truth.size(); ++i) problem.odometry.push_back(edge(i - 1, i));
  for (std::size_t i = 0; i < 2000; ++i) {
    const auto a = static_cast<std::size_t>(random.integer(0, 119)), b = (a + 1 + i % 118) % 120;
    problem.links.push_back(edge(a, b));
  }
  for (std::size_t i = 1; i < truth.size(); ++i) problem.poses[i] = truth[i] * test::random_pose(random, 0.1, 0.1);
  SolveEffort effort;
  LeastSquares squares(problem, effort);
  squares.no_more_surprises();
  EXPECT_TRUE(squares.optimise(std::vector<double>(2000, 1.0), 30));
  EXPECT_FALSE(squares.surprise(0)) << "there is a factor, so this tests nothing";
  for (std::size_t i = 0; i < truth.size(); ++i) {
    EXPECT_LT((problem.poses[i].t - truth[i].t).norm(), 1e-5);
    EXPECT_LT((problem.poses[i].R - truth[i].R).norm(), 1e-5);
  }
}

}  // namespace
}  // namespace onemap::mapping
