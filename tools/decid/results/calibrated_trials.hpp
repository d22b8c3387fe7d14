// Reads and writes the trials of a calibration, and the rows of its tables, as JSON, so that a later call can continue
// from them. The output of `decid calibrate --resume` is its own journal: trials and rows that it has are not fitted
// again.
#pragma once

#include <string>
#include <vector>

#include "base/files/json.hpp"
#include "identify/evaluation/fit_conditions.hpp"

namespace decid::tools {

Json trial_json(const CalibratedTrial& trial);
/// Reads back a trial that has `parameters` parameters. Throws the JSON library's exception if `json` is not a trial.
CalibratedTrial trial_from(const Json& json, std::size_t parameters);

/// Returns the figures of all parameters, and of each by its name.
Json figures_json(const sim::ParameterTable& table, const Calibration& found);
/// Returns a list with one object per row. table: the parameters of the figures.
Json rows_json(const std::vector<FitConditionFigures>& rows, const sim::ParameterTable& table);
/// Reads back what rows_json() returned, except for the faults' texts. Throws the JSON library's exception for others.
std::vector<FitConditionFigures> rows_from_json(const Json& json, const sim::ParameterTable& table);

/// Returns the trials that an earlier call wrote to the file, with `parameters` parameters each. Omits the answers of a
/// network other than `network`. Throws Error if the file is not a calibration, or has other settings.
std::vector<CalibratedTrial> earlier_trials(const std::string& file, const Json& settings, const Json& network,
                                            std::size_t parameters);
/// Returns the rows that an earlier call wrote to the file. Throws Error if the file is not a table, has other
/// settings, lacks values of a row, or has rows that do not begin `conditions`.
std::vector<FitConditionFigures> earlier_rows(const std::string& file, const Json& settings,
                                              const std::vector<FitCondition>& conditions,
                                              const sim::ParameterTable& table);

}  // namespace decid::tools
