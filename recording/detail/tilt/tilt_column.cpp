// The platform's tilt among other columns: see tilt_column.hpp.
#include "recording/detail/tilt/tilt_column.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
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

/// Returns whether the column may follow the protocol's tilt, by each coarse_step-th of its values: reading and
/// resampling all values of a laboratory's columns takes longer than the rest of the work.
class Screen {
 public:
  Screen(const std::vector<double>& expected, double from_hz, double rate_hz)
      : expected_(expected), from_hz_(from_hz), rate_hz_(rate_hz) {}

  bool passes(const OtherColumn& column) {
    constexpr double min_coarse = 0.8;  // a start may lie half a step beside the best one
    if (column.coarse_rad.empty()) return true;
    if (matcher_ == nullptr || step_ != column.coarse_step) prepare(column.coarse_step);
    if (column.coarse_rad.size() + 2 * overhang_of(samples_) < samples_) return true;
    return std::abs(matcher_->match(column.coarse_rad).correlation) >= min_coarse;
  }

 private:
  void prepare(std::size_t step) {
    std::vector<double> coarse;
    const double between = static_cast<double>(step) / from_hz_ * rate_hz_;  // samples of the protocol
    for (std::size_t k = 0;; ++k) {
      const double place = static_cast<double>(k) * between;
      if (place > static_cast<double>(expected_.size() - 1)) break;
      coarse.push_back(expected_[static_cast<std::size_t>(std::lround(place))]);
    }
    step_ = step;
    samples_ = coarse.size();
    matcher_ = std::make_unique<const TiltMatcher>(std::move(coarse), static_cast<int>(overhang_of(samples_)));
  }

  const std::vector<double>& expected_;
  double from_hz_, rate_hz_;
  std::size_t step_ = 0, samples_ = 0;
  std::unique_ptr<const TiltMatcher> matcher_;
};

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

/// Returns whether a name is the body's: "sway_stimulus" is not.
bool is_of_body(const std::string& name) {
  const auto is_of_platform = [](const std::string& word) {
    return word.starts_with("stim") || word.starts_with("platform") || word.starts_with("plattform") ||
           word.starts_with("tilt") || word.starts_with("motor");
  };
  return is_body_name(name) && std::ranges::none_of(words_in(name), is_of_platform);
}

std::string figure(double correlation) {
  return "correlation " + six_digits(std::round(1e4 * correlation) / 1e4);
}

/// A column that moves as the protocol's tilt does.
struct Candidate {
  const OtherColumn* column;
  std::vector<double> rad;
  Match match;
  double offset = 0.0;  ///< measured = gain * prescribed + offset

  bool is_other_size() const { return std::abs(match.gain - 1.0) > good_gain; }
  std::pair<bool, int> rank() const { return {is_other_size(), rank_of(column->name)}; }
};

/// Returns measured - gain * expected, in the mean of the samples that both have.
double offset_of(const std::vector<double>& measured, const std::vector<double>& expected, const Match& match) {
  const long start = std::lround(match.delay_samples),
             end = std::min(std::ssize(expected), std::ssize(measured) - start);
  double sum = 0.0;
  const long first = std::max(0L, -start);
  for (long k = first; k < end; ++k)
    sum += measured[static_cast<std::size_t>(start + k)] - match.gain * expected[static_cast<std::size_t>(k)];
  return end > first ? sum / static_cast<double>(end - first) : 0.0;
}

/// Names a column of the other sign or of the body.
void add_not_used(const OtherColumn& column, double correlation, Recording& recording) {
  constexpr int commanded = 2;
  const bool is_doubtful = column.has_unit && rank_of(column.name) != commanded;
  add_warning(recording.warnings, is_doubtful ? Severity::caution : Severity::info, "tilt_not_used",
              "the column '" + column.name + "' follows the protocol's tilt (" + figure(correlation) + "), but " +
                  (correlation < 0.0 ? "with the other sign" : "is the body's by its name") + ": give " +
                  setting("tilt_column") + " '" + column.name + "' if it is the platform's tilt, else " +
                  setting("tilt_column") + " none");
}

/// Names the other columns in a note, and in a caution one that measured another size.
void add_others(const Candidate& best, const std::vector<Candidate>& found, Recording& recording) {
  std::string others;
  for (const Candidate& other : found)
    if (other.column != best.column) others += (others.empty() ? "'" : ", '") + other.column->name + "'";
  add_info(recording.warnings, "tilt_found",
           "the column '" + best.column->name + "' is assumed to be the platform's tilt, because it follows the " +
               "protocol's (" + figure(best.match.correlation) + ")" +
               (best.column->has_unit ? "" : "; its size is unknown, because it has no unit") +
               (others.empty() ? std::string()
                               : "; so does " + others + ", which " + setting("tilt_column") + " would select"));
  if (best.is_other_size()) return;
  for (const Candidate& other : found)
    if (other.is_other_size() && other.column->has_unit && rank_of(other.column->name) == 0)
      add_caution(recording.warnings, "tilt_of_other_size",
                  "by '" + other.column->name + "' the platform tilted " +
                      six_digits(std::round(1e3 * other.match.gain) / 1e3) +
                      " times as far as the protocol prescribes, by '" + best.column->name +
                      "' as it prescribes: check their units; " + setting("tilt_column") + " '" + other.column->name +
                      "' selects the measured tilt");
}

/// Returns the columns that move as the protocol's tilt does, and names those of the other sign or of the body.
std::vector<Candidate> find_candidates(const std::vector<OtherColumn>& columns, const ProtocolPlan& plan,
                                       double from_hz, Recording& recording) {
  const sim::Experiment& experiment = plan.protocol().experiment;
  const auto* sequence = std::get_if<sim::Sequence>(&experiment.stimulus);
  if (sequence == nullptr) return {};
  const double rate = experiment.sample_rate_hz;
  const long state = std::lround(sequence->state_s * rate);
  if (state < 2) return {};
  const std::vector<double>& expected = plan.tilt_rad();
  Screen screen(expected, from_hz, rate);
  std::vector<Candidate> found;
  for (const OtherColumn& column : columns) {
    if (!screen.passes(column)) continue;
    Candidate candidate{&column, {}, {}};
    try {
      candidate.rad = column.rad();
    } catch (const Error&) {  // words, or hardly any numbers
      continue;
    }
    const std::vector<double> measured = resample(candidate.rad, from_hz, rate);
    if (measured.size() + 2 * overhang_of(expected.size()) < expected.size()) return found;
    const Match match = plan.tilt().match(measured);
    if (std::abs(match.correlation) < min_of_tilt || !is_as_sharp(measured, expected, match, state)) continue;
    if (match.correlation < 0.0 || is_of_body(column.name)) {
      add_not_used(column, match.correlation, recording);
      continue;
    }
    candidate.match = match;
    candidate.offset = offset_of(measured, expected, match);
    found.push_back(std::move(candidate));
  }
  return found;
}

}  // namespace

void look_for_tilt_by_values(const ProtocolPlan& plan, double from_hz, Recording& recording) {
  const std::vector<OtherColumn> columns = std::exchange(recording.other_columns, {});
  const std::string problem = std::exchange(recording.tilt_problem, {});
  std::vector<Candidate> found = find_candidates(columns, plan, from_hz, recording);
  if (found.empty()) {
    if (!problem.empty()) add_caution(recording.warnings, "tilt_not_used", problem);
    return;
  }
  Candidate& best = *std::ranges::min_element(found, {}, &Candidate::rank);
  add_others(best, found, recording);
  recording.tilt_was_found = recording.tilt_was_found_by_values = true;
  recording.tilt_size_is_unknown = !best.column->has_unit;
  if (recording.tilt_size_is_unknown)
    for (double& value : best.rad) value = (value - best.offset) / best.match.gain;
  recording.signals.add({platform_tilt, best.column->name, std::move(best.rad)});
}

}  // namespace decid::recording
