// Made-up recordings in groups, and their comparison.
#pragma once

#include <string>
#include <utility>

#include "base/files/json_object.hpp"
#include "sim/body_model.hpp"
#include "tests/tools/decid/run.hpp"
#include "tools/report/json/groups_json.hpp"

namespace decid::test {

inline const sim::ParameterTable& parameters() {
  return sim::single_pendulum().parameters;
}

/// A recording all of whose parameters are `value`.
inline RecordingResult recording(const std::string& file, double value, Severity severity = Severity::info) {
  RecordingResult made;
  made.file = file;
  made.trial = decid::recording::make_trial({0.0F, 0.01F});
  made.estimate.parameters = sim::Parameters(parameters().size());
  for (double& of_parameter : made.estimate.parameters) of_parameter = value;
  made.warnings = {{severity, "spikes", "some"}};
  return made;
}

inline RecordingResult of_other_tilt(const std::string& file) {
  RecordingResult made = recording(file, 1e6, Severity::caution);
  made.trial.tilt.emplace().is_other_size = true;
  return made;
}

/// Adds a recording of `person` in `group`.
inline void add(Report& report, GroupTable& table, const std::string& group, const std::string& participant,
                RecordingResult made) {
  report.recordings.push_back(std::move(made));
  table.members.push_back({group, participant});
}

inline Json compared(Report& report, GroupTable table) {
  report.groups = report_groups(std::move(table), report);
  return tools::groups_json(report);
}

}  // namespace decid::test
