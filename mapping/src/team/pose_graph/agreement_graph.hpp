#pragma once
#include <bit>
#include <cstdint>
#include <vector>

namespace onemap::mapping {

// Which of n links agree with which: symmetric, nobody with itself. A row of bits each.
class AgreementGraph {
 public:
  explicit AgreementGraph(std::size_t n) : n_(n), words_((n + 63) / 64), rows_(n * words_) {}

  std::size_t size() const { return n_; }
  std::size_t words() const { return words_; }
  const std::uint64_t* row(std::size_t i) const { return rows_.data() + i * words_; }
  bool agree(std::size_t i, std::size_t j) const { return row(i)[j / 64] >> (j % 64) & 1; }
  void set(std::size_t i, std::size_t j) {
    rows_[i * words_ + j / 64] |= 1ull << (j % 64);
    rows_[j * words_ + i / 64] |= 1ull << (i % 64);
  }

 private:
  std::size_t n_, words_;
  std::vector<std::uint64_t> rows_;
};

}  // namespace onemap::mapping
