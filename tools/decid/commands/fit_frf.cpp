// decid fit --frf: see fit_frf.hpp.
#include "tools/decid/commands/fit_frf.hpp"

#include <chrono>
#include <iostream>

#include "base/files/file.hpp"
#include "tools/decid/results/frf_results.hpp"

namespace decid::tools {

void run_frf_fit(const FrfFit& asked) {
  const auto begin = std::chrono::steady_clock::now();
  const frf::Density density(asked.protocol, frf::read_table(asked.table), asked.priors);
  const frf::Fit found = frf::fit(density, asked.particles);
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
  const FrfReport report{density, found, asked.truth, taken.count(), asked.options, asked.body_assumed};
  const std::string json = frf_fit_json(report);
  if (!asked.output.empty()) write_file(asked.output, json);
  if (!asked.draws.empty()) write_frf_draws(asked.draws, report);
  std::cout << (asked.json ? json : frf_fit_text(report));
}

}  // namespace decid::tools
