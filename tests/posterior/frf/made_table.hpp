// Tables of frequency responses made of known controllers.
#pragma once

#include <cmath>
#include <vector>

#include "base/math/random.hpp"
#include "posterior/frf/density.hpp"

namespace decid::test {

/// Rows at these frequencies whose responses are 1, with that confidence where it is not 0.
inline frf::Table empty_table(const std::vector<double>& frequencies_hz, double stddev, int harmonics = 0) {
  frf::Table table;
  table.file = "made.csv";
  if (stddev > 0.0) table.confidence = "sd";
  for (const double hz : frequencies_hz) table.rows.push_back({hz, {1.0, 0.0}, stddev, harmonics});
  return table;
}

/// Eleven frequencies of the short protocol, as they are published.
inline const std::vector<double> short_frequencies_hz = {0.05, 0.15, 0.3, 0.4, 0.55, 0.7, 0.9, 1.1, 1.35, 1.75, 2.2};

/// A state from the prior, of a stable loop.
inline frf::State state_of_prior(const frf::Density& density, const Random& random) {
  std::vector<double> x(density.size());
  for (std::uint64_t number = 0;; number += x.size()) {
    for (std::size_t i = 0; i < x.size(); ++i)
      x[i] = i < density.uniform() ? random.uniform(number + i) : random.normal(number + i);
    const frf::State state = density.state(x);
    if (density.is_stable(state)) return state;
  }
}

/// The table that a state says, with errors as the density has them.
inline frf::Table table_for(const frf::Density& density, const frf::State& state, const Random& random) {
  frf::Table table = density.table();
  std::vector<sim::Complex> responses(table.rows.size());
  density.respond(state, responses);
  for (std::size_t i = 0; i < responses.size(); ++i) {
    const double stddev = std::sqrt(density.variance(i, responses[i], state.error));
    table.rows[i].response =
        responses[i] + stddev * sim::Complex(random.normal(1'000'000 + 2 * i), random.normal(1'000'001 + 2 * i));
  }
  return table;
}

}  // namespace decid::test
