// The tables of decid calibrate --conditions and --faults: fits of trials with one recording artefact per row.
#include <algorithm>
#include <initializer_list>
#include <iostream>
#include <stdexcept>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/text.hpp"
#include "identify/evaluation/fit_conditions.hpp"
#include "tools/decid/commands/calibrate/calibrate.hpp"
#include "tools/decid/interrupt.hpp"
#include "tools/decid/ranks.hpp"
#include "tools/decid/results/calibrated_trials.hpp"
#include "tools/decid/results/results.hpp"

namespace decid::tools {
namespace {

std::string rows_text(const std::vector<FitConditionFigures>& rows) {
  std::string text =
      "| condition | size | trials | MSE | predicted | network's MSE | coverage of 90% | usable | MSE of usable |"
      " predicted of usable | coverage of usable | caution | not usable | usable, beyond 5 sd | network's answer |"
      " mean s | longest s |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const FitConditionFigures& row : rows) {
    using Figures = ParameterCalibration;
    const auto columns = [](const std::optional<Calibration>& found, std::initializer_list<double Figures::*> values) {
      std::string all;
      for (const auto value : values) all += " " + (found ? known_number(found->all.*value, 3) : "-") + " |";
      return all;
    };
    text += format("| %s | %g | %d |", row.fault.name.c_str(), row.fault.size, row.trials) +
            columns(row.figures,
                    {&Figures::mse, &Figures::predicted_variance, &Figures::network_mse, &Figures::coverage90}) +
            format(" %d |", row.usable) +
            columns(row.usable_figures, {&Figures::mse, &Figures::predicted_variance, &Figures::coverage90}) +
            format(" %d | %d | %d | %d | %.1f | %.1f |\n", row.caution, row.not_usable, row.usable_far_off,
                   row.from_network, row.mean_s, row.max_s);
  }
  return text;
}

/// Returns the rows with one of these names; all rows if there are no names. Throws Error for a name without a row.
std::vector<FitCondition> chosen_rows(std::vector<FitCondition> rows, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (std::ranges::any_of(rows, [&](const FitCondition& row) { return row.fault.name == name; })) continue;
    std::string all;
    for (const FitCondition& row : rows)
      if (all.find(row.fault.name) == std::string::npos) all += (all.empty() ? "" : ", ") + row.fault.name;
    throw Error(Code::setting_unknown, "--only", "'" + name + "' is not a row of this table", "name one of " + all);
  }
  if (!names.empty())
    std::erase_if(rows,
                  [&](const FitCondition& row) { return std::ranges::find(names, row.fault.name) == names.end(); });
  return rows;
}

}  // namespace

void run_conditions(const CalibrateOptions& options, const Command& command) {
  if (ranks() != nullptr)
    throw Error(Code::not_supported, "--conditions", "runs in one process", "start it without mpirun");
  std::vector<std::string> inputs;
  ProtocolOptions named = options.protocol;
  if (!options.conditions.empty()) named.name = options.conditions;
  sim::Protocol protocol = named.load(options.common.quiet, &inputs);
  inputs.push_back(options.model);
  refuse_same_file(options.output, inputs);
  if (!options.output.empty()) PendingFile probe(options.output);  // reports an unwritable place before the work
  FitRequest request{{}, options.settings};  // with fit's own priors, except for those that are given
  if (command.count("--prior-start") > 0) request.priors.start_s = options.priors.start_s;
  if (command.count("--prior-gain") > 0) request.priors.gain = options.priors.gain;
  if (command.count("--standing") > 0) request.priors.standing_s = options.priors.standing_s;
  if (protocol.standing_s == 0.0) protocol.standing_s = request.priors.standing_s;
  const Model model = model_or_built_in(options.model);
  CalibrateOptions used = options;
  used.priors = request.priors;
  Json settings = settings_json(used, std::span(&protocol, 1));
  settings["trials"] = options.trials;
  settings["faults"] = options.faults;
  settings["network"] = nn::weights_sha256(model.network);
  const std::vector<FitCondition> conditions =
      chosen_rows(options.faults ? fit_faults(protocol, request.priors) : fit_conditions(protocol), options.only);
  std::vector<FitConditionFigures> rows;
  if (options.resume && path_exists(options.output))
    rows = earlier_rows(options.output, settings, conditions, protocol.parameters());
  if (options.resume && !options.common.quiet)
    std::cerr << "calibrate: " << resuming_text(options.output, rows.size(), conditions.size(), "rows") << '\n';
  Call call = record_call(command, inputs);
  call.seed = options.seed;
  const auto document = [&] {
    return with_call({{"settings", settings}, {"conditions", rows_json(rows, protocol.parameters())}}, call);
  };
  catch_interrupt();
  for (std::size_t i = rows.size(); i < conditions.size() && !interrupted(); ++i) {
    const Fault& fault = conditions[i].fault;
    if (!options.common.quiet)
      std::cerr << format("calibrate: row %zu of %zu, %s\n", i + 1, conditions.size(), fault.text.c_str());
    FitConditionFigures row = fit_condition(model, protocol, conditions[i], request, options.trials, options.seed,
                                            [](std::size_t, const posterior::Progress&) { return !interrupted(); });
    if (row.trials == 0) break;
    rows.push_back(std::move(row));
    if (!options.output.empty()) write_file(options.output, document());
  }
  std::cout << (options.common.json ? document() : rows_text(rows));
  if (rows.size() < conditions.size())
    throw std::runtime_error(format("stopped after %zu of %zu rows%s", rows.size(), conditions.size(),
                                    options.output.empty() ? "" : "; --resume continues"));
}

}  // namespace decid::tools
