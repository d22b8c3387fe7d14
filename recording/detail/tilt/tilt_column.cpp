// The platform's tilt among other columns: see tilt_column.hpp.
#include "recording/detail/tilt/tilt_column.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "base/setting.hpp"
#include "recording/detail/sway/sway_name.hpp"
#include "recording/detail/tilt/tilt_match.hpp"
#include "recording/detail/tilt/tilt_start.hpp"
#include "recording/resample.hpp"
#include "recording/table/columns.hpp"

namespace decid::recording {
namespace {

constexpr double min_of_tilt = 0.9, max_beside = 0.1;

/// Returns whether the cross-correlation of velocities is as narrow as a ternary sequence's. `start`: of `expected` in
/// `measured`; `state`: its samples.
bool is_as_sharp(const std::vector<double>& measured, const std::vector<double>& expected, const Match& match,
                 long state) {
  const long step = std::max(1L, state / 5), start = std::lround(match.delay_samples), reach = state / 2;
  const auto at = [](const std::vector<double>& values, long k) { return values[static_cast<std::size_t>(k)]; };
  const auto product = [&](long lag) {
    double sum = 0.0;
    const long end = std::min(std::ssize(expected), std::ssize(measured) - start - lag);
    for (long k = std::max(0L, -start - lag) + step; k < end; ++k)
      sum += (at(expected, k) - at(expected, k - step)) *
             (at(measured, k + start + lag) - at(measured, k + start + lag - step));
    return match.correlation < 0.0 ? -sum : sum;
  };
  long peak = -reach;
  double largest = product(peak);
  for (long lag = -reach + 1; lag <= reach; ++lag)
    if (const double value = product(lag); value > largest) {
      largest = value;
      peak = lag;
    }
  return largest > 0.0 && std::max(product(peak - state), product(peak + state)) < max_beside * largest;
}

/// Returns 0 for a measured tilt by its name, 2 for a commanded one, else 1.
int rank_of(const std::string& name) {
  for (const std::string& word : words_in(name)) {
    if (one_of(word, {"measured", "meas", "actual", "act", "ist", "real", "encoder", "sensor", "feedback", "gemessen"}))
      return 0;
    if (one_of(word, {"command", "commanded", "cmd", "target", "desired", "soll", "demand", "reference", "ref",
                      "setpoint", "prescribed", "input"}))
      return 2;
  }
  return 1;
}

std::string figure(double correlation) {
  return "correlation " + six_digits(std::round(1e4 * correlation) / 1e4);
}

}  // namespace

void look_for_tilt_by_values(const ProtocolPlan& plan, double from_hz, Recording& recording) {
  const std::vector<Signal<double>> columns = std::exchange(recording.other_columns, {});
  const sim::Experiment& experiment = plan.protocol().experiment;
  const auto* sequence = std::get_if<sim::Sequence>(&experiment.stimulus);
  if (sequence == nullptr) return;
  const double rate = experiment.sample_rate_hz;
  const long state = std::lround(sequence->state_s * rate);
  if (state < 2) return;
  const std::vector<double> expected = prescribed_tilt(plan.protocol());
  const Signal<double>* best = nullptr;
  double correlation = 0.0;
  std::string others;
  for (const Signal<double>& column : columns) {
    const std::vector<double> measured = from_hz == rate ? column.rad : resample(column.rad, from_hz, rate);
    if (measured.size() + 2 * overhang_of(expected.size()) < expected.size()) return;
    const Match match = plan.tilt().match(measured);
    if (std::abs(match.correlation) < min_of_tilt || !is_as_sharp(measured, expected, match, state)) continue;
    if (match.correlation < 0.0 || is_body_name(column.column)) {
      add_caution(recording.warnings, "tilt_not_used",
                  "the column '" + column.column + "' follows the protocol's tilt (" + figure(match.correlation) +
                      "), but " + (match.correlation < 0.0 ? "with the other sign" : "is the body's by its name") +
                      ": give " + setting("tilt_column") + " '" + column.column +
                      "' if it is the platform's tilt, else " + setting("tilt_column") + " none");
      continue;
    }
    const bool is_better = best == nullptr || rank_of(column.column) < rank_of(best->column);
    if (best != nullptr) others += (others.empty() ? "'" : ", '") + (is_better ? best : &column)->column + "'";
    if (is_better) {
      best = &column;
      correlation = match.correlation;
    }
  }
  if (best == nullptr) return;
  add_info(recording.warnings, "tilt_found",
           "no column is the tilt by its name; '" + best->column + "' follows the protocol's tilt (" +
               figure(correlation) + ")" +
               (others.empty() ? std::string()
                               : ", and so does " + others + ", which " + setting("tilt_column") + " would select"));
  recording.signals.add(*best);
  recording.tilt_was_found = true;
}

}  // namespace decid::recording
