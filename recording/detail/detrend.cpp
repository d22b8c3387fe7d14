// Subtracts the offset and drift of a trial: see detrend.hpp.
#include "recording/detail/detrend.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "base/math/statistics.hpp"
#include "recording/table/columns.hpp"

namespace decid::recording {
namespace {

/// Returns the mean of samples begin .. end - 1.
double mean_of_part(const std::vector<double>& signal, std::size_t begin, std::size_t end) {
  return decid::mean(std::span(signal).subspan(begin, end - begin));
}

}  // namespace

void detrend(std::vector<double>& sway, const sim::Protocol& protocol, Detrend kind, Warnings& warnings) {
  if (kind == Detrend::none) return;
  const double rate = protocol.experiment.sample_rate_hz, lead_in_s = protocol.experiment.lead_in_s(),
               cycle_s = protocol.experiment.cycle_s();
  const int cycles = protocol.experiment.cycles();
  const auto sample_at = [&](int cycle) {
    const double at = std::round((lead_in_s + cycle * cycle_s) * rate);
    return std::min(static_cast<std::size_t>(at), sway.size());
  };
  const std::size_t begin = sample_at(0), end = sample_at(cycles);
  double slope = 0.0;  // per sample
  if (kind == Detrend::linear) {
    // Least squares: over the means of the cycles, or over the samples.
    const bool by_cycle = cycles > 1;
    const std::size_t count = by_cycle ? static_cast<std::size_t>(cycles) : end - begin;
    const double middle = 0.5 * (static_cast<double>(count) - 1.0), whole = mean_of_part(sway, begin, end);
    double product = 0.0, squares = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      const double at = static_cast<double>(i) - middle;
      const int cycle = static_cast<int>(i);
      const double value = by_cycle ? mean_of_part(sway, sample_at(cycle), sample_at(cycle + 1)) : sway[begin + i];
      product += at * (value - whole);
      squares += at * at;
    }
    slope = product / squares / (by_cycle ? cycle_s * rate : 1.0);
  }
  for (std::size_t k = 0; k < sway.size(); ++k) sway[k] -= slope * static_cast<double>(k);
  const double offset = mean_of_part(sway, begin, end);
  for (double& value : sway) value -= offset;
  const double drift = slope * static_cast<double>(sway.size());
  add_info(warnings, "detrended",
           "subtracted: an offset of " + three_digits((offset + 0.5 * drift) / sim::rad_per_deg) + " degrees" +
               (kind == Detrend::linear
                    ? " and a drift of " + three_digits(drift / sim::rad_per_deg) + " degrees over the trial"
                    : ""));
}

}  // namespace decid::recording
