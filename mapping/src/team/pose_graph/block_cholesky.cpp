#include "block_cholesky.hpp"

#include <Eigen/Cholesky>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>

namespace onemap::mapping {

namespace {

using Rows = std::vector<std::size_t>;

Rows elimination_order(const BlockMatrix& pattern) {
  const auto size = static_cast<int>(pattern.size());
  std::vector<Eigen::Triplet<double, int>> entries;
  for (std::size_t j = 0; j < pattern.size(); ++j) {
    entries.emplace_back(static_cast<int>(j), static_cast<int>(j), 1);
    for (std::size_t k = pattern.first[j]; k < pattern.first[j + 1]; ++k) {
      entries.emplace_back(static_cast<int>(pattern.row[k]), static_cast<int>(j), 1);
      entries.emplace_back(static_cast<int>(j), static_cast<int>(pattern.row[k]), 1);
    }
  }
  Eigen::SparseMatrix<double> blocks(size, size);
  blocks.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(blocks, order);  // who is eliminated first, second ...
  Rows place(pattern.size());
  for (int i = 0; i < size; ++i) place[static_cast<std::size_t>(order.indices()[i])] = static_cast<std::size_t>(i);
  return place;
}

// Into `to`, which is ascending, what of `from` is above `column`.
void merge_above(const Rows& from, std::size_t column, Rows& to) {
  Rows merged;
  merged.reserve(from.size() + to.size());
  std::set_union(std::upper_bound(from.begin(), from.end(), column), from.end(), to.begin(), to.end(),
                 std::back_inserter(merged));
  to = std::move(merged);
}

// The rows of L below the diagonal of each column: those of the matrix, and of the columns that go into it first.
std::optional<std::vector<Rows>> rows_of_factor(std::vector<Rows> rows, std::size_t most, std::size_t& products) {
  products = 0;
  for (std::size_t j = 0; j < rows.size(); ++j) {
    products += rows[j].size() * (rows[j].size() + 3) / 2 + 1;
    if (products > most) return std::nullopt;
    if (!rows[j].empty()) merge_above(rows[j], rows[j][0], rows[rows[j][0]]);
  }
  return rows;
}

}  // namespace

std::optional<BlockCholesky> BlockCholesky::of(const BlockMatrix& pattern, std::size_t most_products) {
  BlockCholesky out;
  out.place_ = elimination_order(pattern);
  std::vector<Rows> rows(pattern.size());
  const auto visit = [&](const auto& with) {
    for (std::size_t j = 0; j < pattern.size(); ++j)
      for (std::size_t k = pattern.first[j]; k < pattern.first[j + 1]; ++k)
        with(out.place_[j], out.place_[pattern.row[k]]);
  };
  visit([&](std::size_t j, std::size_t i) { rows[std::min(i, j)].push_back(std::max(i, j)); });
  for (Rows& column : rows) std::sort(column.begin(), column.end());
  auto filled = rows_of_factor(std::move(rows), most_products, out.products_);
  if (!filled) return std::nullopt;
  out.first_.push_back(0);
  for (const Rows& column : *filled) {
    out.row_.insert(out.row_.end(), column.begin(), column.end());
    out.first_.push_back(out.row_.size());
  }
  out.diagonal_.resize(pattern.size());
  out.below_.resize(out.row_.size());
  visit([&](std::size_t j, std::size_t i) {
    const Rows& column = (*filled)[std::min(i, j)];
    const auto found = std::lower_bound(column.begin(), column.end(), std::max(i, j)) - column.begin();
    out.from_.push_back(out.first_[std::min(i, j)] + static_cast<std::size_t>(found));
    out.mirrored_.push_back(i < j);
  });
  return out;
}

bool BlockCholesky::factor(const BlockMatrix& H, double damping) {
  for (std::size_t i = 0; i < place_.size(); ++i) {
    diagonal_[place_[i]] = H.diagonal[i];
    diagonal_[place_[i]].diagonal() *= 1 + damping;
  }
  for (Matrix6d& block : below_) block.setZero();
  for (std::size_t k = 0; k < from_.size(); ++k)
    if (mirrored_[k])
      below_[from_[k]] = H.below[k].transpose();
    else
      below_[from_[k]] = H.below[k];
  for (std::size_t j = 0; j < diagonal_.size(); ++j)
    if (!eliminate(j)) return false;
  return true;
}

bool BlockCholesky::eliminate(std::size_t j) {
  const Eigen::LLT<Matrix6d> llt(diagonal_[j]);
  if (llt.info() != Eigen::Success) return false;
  diagonal_[j] = llt.matrixL();
  const Matrix6d inverse = diagonal_[j].triangularView<Eigen::Lower>().solve(Matrix6d::Identity()).transpose();
  for (std::size_t k = first_[j]; k < first_[j + 1]; ++k) below_[k] = below_[k].lazyProduct(inverse).eval();
  for (std::size_t k = first_[j]; k < first_[j + 1]; ++k) subtract(j, k);
  return true;
}

// What column j takes from column row_[k], whose rows hold all that column j has below it.
void BlockCholesky::subtract(std::size_t j, std::size_t k) {
  const std::size_t column = row_[k];
  const Matrix6d by = below_[k].transpose();
  diagonal_[column].noalias() -= below_[k].lazyProduct(by);
  std::size_t to = first_[column];
  for (std::size_t i = k + 1; i < first_[j + 1]; ++i) {
    while (row_[to] != row_[i]) ++to;
    below_[to].noalias() -= below_[i].lazyProduct(by);
  }
}

Eigen::VectorXd BlockCholesky::solve(const Eigen::VectorXd& b) const {
  Eigen::VectorXd x(b.size()), out(b.size());
  for (std::size_t i = 0; i < place_.size(); ++i) x.segment<6>(row_of(place_[i])) = b.segment<6>(row_of(i));
  for (std::size_t j = 0; j < diagonal_.size(); ++j) {
    const Vector6d y = diagonal_[j].triangularView<Eigen::Lower>().solve(x.segment<6>(row_of(j)));
    x.segment<6>(row_of(j)) = y;
    for (std::size_t k = first_[j]; k < first_[j + 1]; ++k) x.segment<6>(row_of(row_[k])).noalias() -= below_[k] * y;
  }
  for (std::size_t j = diagonal_.size(); j-- > 0;) {
    Vector6d y = x.segment<6>(row_of(j));
    for (std::size_t k = first_[j]; k < first_[j + 1]; ++k)
      y.noalias() -= below_[k].transpose() * x.segment<6>(row_of(row_[k]));
    x.segment<6>(row_of(j)) = diagonal_[j].transpose().triangularView<Eigen::Upper>().solve(y);
  }
  for (std::size_t i = 0; i < place_.size(); ++i) out.segment<6>(row_of(i)) = x.segment<6>(row_of(place_[i]));
  return out;
}

// |L^-1 J|^2. Only the columns on the way from J's rows to the last one have a part in it.
Matrix6d BlockCholesky::inverse_between(const std::vector<Row>& J) const {
  std::vector<Matrix6d> y(diagonal_.size(), Matrix6d::Zero());
  std::vector<bool> reached(diagonal_.size());
  std::size_t lowest = diagonal_.size();
  for (const Row& row : J) {
    y[place_[row.row]] += row.block;
    reached[place_[row.row]] = true;
    lowest = std::min(lowest, place_[row.row]);
  }
  Matrix6d out = Matrix6d::Zero();
  for (std::size_t j = lowest; j < diagonal_.size(); ++j) {
    if (!reached[j]) continue;
    const Matrix6d solved = diagonal_[j].triangularView<Eigen::Lower>().solve(y[j]);
    out.noalias() += solved.transpose().lazyProduct(solved);
    for (std::size_t k = first_[j]; k < first_[j + 1]; ++k) {
      y[row_[k]].noalias() -= below_[k].lazyProduct(solved);
      reached[row_[k]] = true;
    }
  }
  return out;
}

}  // namespace onemap::mapping
