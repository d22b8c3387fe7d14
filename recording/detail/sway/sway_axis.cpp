// The axis of a centre of mass: see sway_axis.hpp.
#include "recording/detail/sway/sway_axis.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/setting.hpp"
#include "recording/quality/detail/response_check.hpp"
#include "recording/table/columns.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::recording {

namespace {

/// A centre of mass reaches a gain of 82 and more in trials of 121 s of twelve simulated people, and a signal without a
/// response to the tilt 20 and less. The gain of a response is proportional to the length.
constexpr double min_gain = 60.0, min_gain_of_turned = 35.0, tuned_s = 120.0, min_scaled_gain = 26.0;
constexpr double min_turned = 0.2;                       // the sine of 11 degrees
constexpr double max_start_s = 3.0, shift_step_s = 0.5;  // of a recording that starts late or early

struct Axis {
  Recording recording;
  std::size_t known_warnings;  ///< before it was brought to the protocol
  Trial trial;
  std::vector<double> sway_rad;
  ResponseCheck::Response response{};

  const std::string& name() const { return trial.signals.at(com_sway).column; }
};

Axis brought(const ProtocolPlan& plan, const TrialOptions& options, Recording recording) {
  const std::size_t warnings = recording.warnings.size();
  Trial trial = bring_to_protocol(recording, plan, options);
  const std::vector<float>& sway = trial.sway_rad();
  std::vector<double> sway_rad(sway.begin(), sway.end());
  return {std::move(recording), warnings, std::move(trial), std::move(sway_rad)};
}

/// Sets the responses at the smallest shift at which one of them exceeds `required_gain`. Returns the axis with the
/// largest response, or the end without any.
std::vector<Axis>::iterator find_response(std::vector<Axis>& axes, const ResponseCheck& check, double required_gain) {
  const auto far = [&](const Axis& axis) { return axis.response.gain > required_gain ? axis.response.rms_rad : 0.0; };
  for (double size_s = 0.0; size_s <= max_start_s; size_s += shift_step_s)
    for (const double shift_s : {size_s, -size_s}) {
      if (size_s == 0.0 && std::signbit(shift_s)) continue;
      for (Axis& axis : axes) axis.response = check.response_of(axis.sway_rad, shift_s);
      const auto best = std::ranges::max_element(axes, {}, far);
      if (far(*best) > 0.0) return best;
    }
  return axes.end();
}

}  // namespace

std::vector<int> axes_beside(const Table& table, int sway, int time) {
  const auto is_axis = [](const std::string& word) { return one_of(word, {"x", "y", "z"}); };
  const std::vector<std::string> parts = words(table.own_name(sway));
  std::vector<int> columns;
  for (int column = 0; column < table.columns(); ++column) {
    const std::vector<std::string> others = words(table.own_name(column));
    if (column == sway || column == time || others.size() != parts.size() || table.rows(column) != table.rows(sway))
      continue;
    std::size_t axes = 0, differences = 0;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (parts[i] == others[i]) continue;
      ++differences;
      if (is_axis(parts[i]) && is_axis(others[i])) ++axes;
    }
    if (axes == 1 && differences == 1) columns.push_back(column);
  }
  return columns;
}

bool may_be_axis(const Table& table, int column) {
  try {
    static_cast<void>(table.numbers_of_each(column, table.rows(column), Missing::kept));
  } catch (const Error&) {
    return false;  // words
  }
  std::vector<double> values;
  try {
    values = table.numbers(column, Missing::kept);
  } catch (const Error&) {
    return true;  // single cells are no numbers
  }
  std::erase_if(values, [](double value) { return std::isnan(value); });
  return std::ranges::adjacent_find(values, std::ranges::not_equal_to()) != values.end();
}

Trial bring_axis(const ProtocolPlan& plan, const TrialOptions& options, Recording& recording) {
  std::vector<Recording> others = std::exchange(recording.other_axes, {});
  std::string problem = std::exchange(recording.axis_problem, {});
  std::vector<Axis> axes;
  axes.push_back(brought(plan, options, recording));
  std::string names = "'" + axes.front().name() + "'";
  for (Recording& other : others) {
    const std::string name = other.signals.at(com_sway).column;
    try {
      axes.push_back(brought(plan, options, std::move(other)));
      names += ", '" + name + "'";
    } catch (const Error& error) {
      problem += "; '" + name + "' cannot be brought to the protocol: " + error.problem();
    }
  }
  const sim::Protocol& protocol = plan.protocol();
  const double length_s = static_cast<double>(protocol.samples()) / protocol.experiment.sample_rate_hz;
  const auto scaled = [&](double gain) { return std::max(min_scaled_gain, gain * std::min(1.0, length_s / tuned_s)); };
  const auto best = find_response(axes, plan.response(), scaled(min_gain));
  const std::string are = names + (axes.size() > 1 ? " are axes" : " is an axis") + " of one centre of mass";
  const auto chosen = best == axes.end() ? axes.begin() : best;
  Warnings notes;
  if (best == axes.end()) {
    add_caution(notes, "axis_assumed",
                are + (axes.size() > 1 ? ", none of which clearly follows" : ", which does not clearly follow") +
                    " the protocol's tilt" + problem + "; decid uses '" + chosen->name() +
                    "': name the axis in the direction of the tilt with " + setting("column"));
  } else {
    for (const Warning& warning : recording.warnings)  // rows are dropped only once
      if (best != axes.begin() && one_of(warning.code, {"copied_rows", "separate_rows"})) notes.push_back(warning);
    add_info(notes, "axis_chosen",
             are + "; decid uses '" + best->name() + "', which follows the protocol's tilt" + problem);
    const auto ratio = [&](const Axis& other) { return other.response.rms_rad / best->response.rms_rad; };
    for (const Axis& other : axes)
      if (&other != &*best && other.response.gain > scaled(min_gain_of_turned) && ratio(other) > min_turned)
        add_caution(notes, "axes_turned",
                    "'" + other.name() + "' follows the protocol's tilt too, " + three_digits(ratio(other)) +
                        " times as far as '" + best->name() +
                        "': the axes are perhaps turned against the tilt; turn them so that one has its direction");
  }
  recording = std::move(chosen->recording);
  recording.warnings.insert(recording.warnings.begin() + static_cast<std::ptrdiff_t>(chosen->known_warnings),
                            notes.begin(), notes.end());
  return std::move(chosen->trial);
}

}  // namespace decid::recording
