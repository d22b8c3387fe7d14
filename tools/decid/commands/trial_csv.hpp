// Columns that the CSV files of decid simulate and decid stimulus share.
#pragma once

#include <vector>

#include "sim/protocol/protocol.hpp"

namespace decid::tools {

inline constexpr int csv_digits = 10;

/// Returns the time and the tilt in degrees of every sample.
inline std::vector<std::vector<double>> time_and_tilt(const sim::Protocol& protocol, const sim::Stimulus& stimulus) {
  std::vector<std::vector<double>> columns(2);
  for (const double tilt_rad : sim::tilt_at_samples(protocol.experiment, stimulus)) {
    columns[0].push_back(static_cast<double>(columns[0].size()) / protocol.experiment.sample_rate_hz);
    columns[1].push_back(tilt_rad / sim::rad_per_deg);
  }
  return columns;
}

}  // namespace decid::tools
