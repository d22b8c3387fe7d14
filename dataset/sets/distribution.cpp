// Distributions: see distribution.hpp.
#include "dataset/sets/distribution.hpp"

#include <algorithm>
#include <cmath>

namespace decid::dataset {

Distribution::Distribution(double low, double high, int bins)
    : low_(low), high_(high), bins_(static_cast<std::size_t>(bins), 0) {}

void Distribution::add(double value) {
  min_ = count_ == 0 ? value : std::min(min_, value);
  max_ = count_ == 0 ? value : std::max(max_, value);
  ++count_;
  const double difference = value - mean_;
  mean_ += difference / static_cast<double>(count_);
  squares_ += difference * (value - mean_);
  if (value < low_) {
    ++below_;
  } else if (value > high_) {
    ++above_;
  } else {
    const auto bin = static_cast<std::size_t>((value - low_) / (high_ - low_) * static_cast<double>(bins_.size()));
    ++bins_[std::min(bin, bins_.size() - 1)];
  }
}

double Distribution::stddev() const noexcept {
  return count_ == 0 ? 0.0 : std::sqrt(squares_ / static_cast<double>(count_));
}

TrialDistributions::TrialDistributions(const sim::ParameterTable& table) {
  for (const sim::ParameterInfo& info : table) parameters.emplace_back(info.low, info.high, 20);
}

void TrialDistributions::add(const sim::Parameters& values, double peak_to_peak_rad) {
  for (std::size_t i = 0; i < values.size(); ++i) parameters[i].add(values[i]);
  peak_to_peak.add(peak_to_peak_rad);
}

}  // namespace decid::dataset
