#include "block_matrix.hpp"

#include <algorithm>

namespace onemap::mapping {

BlockMatrix::BlockMatrix(std::size_t size, std::vector<Place> places) : diagonal(size), first(size + 1) {
  for (auto& [column, r] : places)
    if (column > r) std::swap(column, r);
  std::erase_if(places, [](const Place& place) { return place.first == place.second; });
  std::sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end()), places.end());
  for (const auto& [column, r] : places) {
    ++first[column + 1];
    row.push_back(r);
  }
  for (std::size_t j = 0; j < size; ++j) first[j + 1] += first[j];
  below.resize(row.size());
  set_zero();
}

std::size_t BlockMatrix::find(std::size_t r, std::size_t column) const {
  const auto begin = row.begin();
  return static_cast<std::size_t>(std::lower_bound(begin + static_cast<std::ptrdiff_t>(first[column]),
                                                   begin + static_cast<std::ptrdiff_t>(first[column + 1]), r) -
                                  begin);
}

void BlockMatrix::set_zero() {
  for (Matrix6d& block : diagonal) block.setZero();
  for (Matrix6d& block : below) block.setZero();
}

Eigen::VectorXd BlockMatrix::times(const Eigen::VectorXd& x) const {
  Eigen::VectorXd out(x.size());
  const auto at = [](std::size_t i) { return static_cast<Eigen::Index>(6 * i); };
  for (std::size_t j = 0; j < size(); ++j) out.segment<6>(at(j)).noalias() = diagonal[j] * x.segment<6>(at(j));
  for (std::size_t j = 0; j < size(); ++j)
    for (std::size_t k = first[j]; k < first[j + 1]; ++k) {
      out.segment<6>(at(row[k])).noalias() += below[k] * x.segment<6>(at(j));
      out.segment<6>(at(j)).noalias() += below[k].transpose() * x.segment<6>(at(row[k]));
    }
  return out;
}

}  // namespace onemap::mapping
