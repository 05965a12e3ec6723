#pragma once
#include <cmath>
#include <vector>

namespace onemap::hal::imaging {

// The deviation of an estimate from what it would be without each of some groups of its images (Tukey's jackknife). The
// groups are stretches of time: images beside each other see the same, with the same error.
inline constexpr int kGroups = 8, kLeastGroups = 4;
inline int group_of(int image, int images, int groups) { return image * groups / images; }

class Spread {
 public:
  void add(double without_one) { values_.push_back(without_one); }
  double sigma() const {
    const auto n = static_cast<double>(values_.size());
    double mean = 0, squares = 0;
    for (const double v : values_) mean += v / n;
    for (const double v : values_) squares += (v - mean) * (v - mean);
    return std::sqrt(squares * (n - 1) / n);
  }

 private:
  std::vector<double> values_;
};

}  // namespace onemap::hal::imaging
