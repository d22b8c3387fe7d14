// The axis of a centre of mass: see sway_axis.hpp.
#include "recording/detail/sway/sway_axis.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "base/setting.hpp"
#include "recording/quality/detail/response_check.hpp"
#include "recording/table/columns.hpp"

namespace decid::recording {

namespace {

/// A centre of mass reaches a gain of 82 and more in the trials of twelve simulated people, and a signal without a
/// response to the tilt 20 and less.
constexpr double min_gain = 60.0, min_gain_of_turned = 35.0;
constexpr double min_turned = 0.2;  // the sine of 11 degrees

struct Axis {
  Recording recording;
  ResponseCheck::Response response;

  const std::string& name() const { return recording.signals.at(com_sway).column; }
  bool responds() const { return response.gain > min_gain; }
};

ResponseCheck::Response response_of(const ProtocolPlan& plan, const TrialOptions& options, Recording recording) {
  const Trial trial = bring_to_protocol(recording, plan, options);
  const std::vector<float>& sway = trial.signals.at(com_sway).rad;
  return plan.response().response_of(std::vector<double>(sway.begin(), sway.end()));
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

void choose_axis(const ProtocolPlan& plan, const TrialOptions& options, Recording& recording) {
  std::vector<Recording> others = std::exchange(recording.other_axes, {});
  std::vector<Axis> axes;
  axes.push_back({recording, response_of(plan, options, recording)});
  std::string names = "'" + axes.front().name() + "'";
  for (Recording& other : others) {
    try {
      const ResponseCheck::Response response = response_of(plan, options, other);
      axes.push_back({std::move(other), response});
      names += ", '" + axes.back().name() + "'";
    } catch (const Error&) {  // the first axis was brought to the protocol, so this one is not the sway
    }
  }
  const auto far = [](const Axis& axis) { return axis.responds() ? axis.response.rms_rad : 0.0; };
  const auto best = std::ranges::max_element(axes, {}, far);
  if (!best->responds())
    throw Error(Code::column_ambiguous, recording.file,
                "has several axes of one centre of mass, " + names + ", and none clearly follows the protocol's tilt",
                "name the one in the direction of the tilt with " + setting("column"));
  Recording chosen = best->recording;
  for (const Warning& warning : recording.warnings)  // the copies are dropped only once
    if (best != axes.begin() && warning.code == "copied_rows") chosen.warnings.push_back(warning);
  add_info(
      chosen.warnings, "axis_chosen",
      names + " are axes of one centre of mass; decid uses '" + best->name() + "', which follows the protocol's tilt");
  const auto ratio = [&](const Axis& other) { return other.response.rms_rad / best->response.rms_rad; };
  for (const Axis& other : axes)
    if (&other != &*best && other.response.gain > min_gain_of_turned && ratio(other) > min_turned)
      add_caution(chosen.warnings, "axes_turned",
                  "'" + other.name() + "' follows the protocol's tilt too, " + three_digits(ratio(other)) +
                      " times as far as '" + best->name() +
                      "': the axes are perhaps turned against the tilt; turn them so that one has its direction");
  recording = std::move(chosen);
}

}  // namespace decid::recording
