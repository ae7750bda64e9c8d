// Running mean and variance (Welford 1962, "Note on a Method for Calculating Corrected Sums of
// Squares and Products", Technometrics 4). The moments of two sets of values can be merged (Chan,
// Golub & LeVeque 1983).
#pragma once

#include <cmath>
#include <cstdint>

namespace emberline {

class Moments {
 public:
  void add(double x) {
    ++count_;
    const double delta = x - mean_;
    mean_ += delta / double(count_);
    m2_ += delta * (x - mean_);
  }
  void merge(const Moments& o) {
    if (o.count_ == 0) return;
    const double n = double(count_ + o.count_);
    const double delta = o.mean_ - mean_;
    m2_ += o.m2_ + delta * delta * double(count_) * double(o.count_) / n;
    mean_ += delta * double(o.count_) / n;
    count_ += o.count_;
  }

  uint64_t count() const { return count_; }
  double mean() const { return mean_; }
  // Returns the variance of the values, not of their mean.
  double variance() const { return count_ > 1 ? m2_ / double(count_ - 1) : 0.0; }
  double standard_error() const {
    return count_ > 1 ? std::sqrt(variance() / double(count_)) : 0.0;
  }

 private:
  uint64_t count_ = 0;
  double mean_ = 0.0;
  double m2_ = 0.0;
};

}  // namespace emberline
