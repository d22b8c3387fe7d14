// Measurements with Gaussian evidence, their analysis, and what it should find, for tests of cohorts.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "base/math/random.hpp"
#include "identify/cohort/cohort.hpp"
#include "sim/body_model.hpp"

namespace decid::test {

/// Parameters with the range from 0 to 1.
inline sim::ParameterTable unit_ranges(std::size_t count) {
  std::vector<sim::ParameterInfo> rows;
  for (std::size_t p = 0; p < count; ++p) {
    const std::string name = "p" + std::to_string(p);
    rows.push_back({name, name, name, "1", 0.0, 1.0, false});
  }
  return sim::ParameterTable(std::move(rows));
}

/// Normal deviates, one after the other.
class Normals {
 public:
  explicit Normals(std::uint64_t seed) : random_(seed, Stream::user, 0) {}
  double operator()() { return random_.normal(used_++); }

 private:
  Random random_;
  std::uint64_t used_ = 0;
};

/// Returns a network's distribution whose evidence about the coordinates is N(at, sd^2), the prior divided out.
inline cohort::Measurement gaussian(const std::vector<double>& at, double sd) {
  const double precision = 1.0 / (sd * sd), with_prior = precision + 1.0;
  std::vector<double> outputs{0.0};
  for (const double value : at) outputs.push_back(value * precision / with_prior);
  for (std::size_t p = 0; p < at.size(); ++p) outputs.push_back(0.5 * std::log(with_prior));
  outputs.resize(mixture_outputs(1, at.size()), 0.0);
  return cohort::Measurement::of_distribution(
      ParameterDistribution(Mixture(1, at.size(), outputs), unit_ranges(at.size())));
}

inline cohort::Result analyse(const std::vector<cohort::Recording>& recordings, std::size_t parameters,
                              const cohort::Settings& settings = {}) {
  const sim::ParameterTable table = unit_ranges(parameters);
  const std::vector<sim::ParameterInfo> ranges(table.begin(), table.end());
  return cohort::analyse(recordings, ranges, settings);
}

/// Four standard deviations: about one seed in 10,000 fails.
inline bool holds(const cohort::Quantity& quantity, double value) {
  return std::abs(quantity.mean - value) <= 4.0 * quantity.sd;
}

}  // namespace decid::test
