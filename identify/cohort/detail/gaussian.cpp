// Nodes of a tree of Gaussians: see gaussian.hpp.
#include "identify/cohort/detail/gaussian.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "base/math/cholesky.hpp"
#include "base/math/math.hpp"

namespace decid::cohort {

void Evidence::clear() {
  std::ranges::fill(precision, 0.0);
  std::ranges::fill(shift, 0.0);
}

void Evidence::add(const Evidence& other) {
  for (std::size_t i = 0; i < precision.size(); ++i) precision[i] += other.precision[i];
  for (std::size_t i = 0; i < shift.size(); ++i) shift[i] += other.shift[i];
}

double row_times(std::span<const double> precision, std::size_t i, std::span<const double> x) {
  double sum = 0.0;
  for (std::size_t j = 0; j < x.size(); ++j) sum += precision[j <= i ? triangle(i) + j : triangle(j) + i] * x[j];
  return sum;
}

void Deviation::prepare(std::span<const double> sd, const Evidence& evidence) {
  root_ = evidence.precision;
  for (std::size_t i = 0; i < size_; ++i) root_[triangle(i) + i] += 1.0 / (sd[i] * sd[i]);
  if (!factorize(size_, root_))
    throw Error(Code::value_invalid, "cohort", "the evidence of a recording is not finite", "leave the recording out");
  invert_lower(size_, root_);
}

void Deviation::whiten(const Evidence& evidence, std::span<double> out) const {
  for (std::size_t i = 0; i < size_; ++i)
    for (std::size_t j = 0; j < size_; ++j) {
      double sum = 0.0;
      for (std::size_t k = 0; k <= i; ++k)
        sum += root_[triangle(i) + k] * evidence.precision[k >= j ? triangle(k) + j : triangle(j) + k];
      out[i * size_ + j] = sum;
    }
}

void Deviation::whiten(std::span<const double> shift, std::span<double> out) const {
  for (std::size_t i = 0; i < size_; ++i) {
    double sum = 0.0;
    for (std::size_t k = 0; k <= i; ++k) sum += root_[triangle(i) + k] * shift[k];
    out[i] = sum;
  }
}

void Deviation::absorb(std::span<const double> sd, const Evidence& evidence, Evidence& about_location) {
  prepare(sd, evidence);
  whiten(evidence, by_root_);
  whiten(evidence.shift, shifted_);
  about_location = evidence;
  for (std::size_t i = 0; i < size_; ++i) {
    for (std::size_t k = 0; k < size_; ++k) about_location.shift[i] -= by_root_[k * size_ + i] * shifted_[k];
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = 0.0;
      for (std::size_t k = 0; k < size_; ++k) sum += by_root_[k * size_ + i] * by_root_[k * size_ + j];
      about_location.precision[triangle(i) + j] -= sum;
    }
  }
}

double Deviation::log_root_determinant() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < size_; ++i) sum += log(root_[triangle(i) + i]);
  return sum;
}

void Deviation::draw(std::span<const double> shift, std::span<const double> normal, std::span<double> d) {
  whiten(shift, work_);
  for (std::size_t i = 0; i < size_; ++i) work_[i] += normal[i];
  for (std::size_t i = 0; i < size_; ++i) {
    double sum = 0.0;
    for (std::size_t k = i; k < size_; ++k) sum += root_[triangle(k) + i] * work_[k];
    d[i] = sum;
  }
}

}  // namespace decid::cohort
