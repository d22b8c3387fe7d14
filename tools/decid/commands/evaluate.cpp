// decid evaluate: the error of one model, or of several models side by side, on a data set.
#include <algorithm>
#include <iostream>
#include <memory>

#include "base/error.hpp"
#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "dataset/npz/npz.hpp"
#include "identify/evaluation/calibration.hpp"
#include "identify/network/for_body.hpp"
#include "identify/network/prediction.hpp"
#include "identify/training/training.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/ranks.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/firmware/quantise.hpp"
#include "tools/report/json/parameters_json.hpp"
#include "tools/report/json/recording_json.hpp"

namespace decid::tools {
namespace {

struct EvaluateOptions {
  CommonOptions common;
  std::vector<std::string> models;  ///< files; one that is empty: the built-in model
  std::string data, split;
  bool int8 = false;
};

/// A model and how its answers compare with the trials' parameters.
struct Evaluated {
  std::string name;
  sim::ParameterTable table;
  Evaluation result;
  std::optional<NetworkCalibration> calibration;
};

/// The outputs of the model's network, or of the one in 8-bit integers that a firmware would have.
std::vector<float> compute_outputs(Model& model, bool int8, int trials, const Sways& sways) {
  if (!int8) return predict(model, trials, 64, sways, ranks());
  FirmwarePlan plan = plan_firmware(model, {.int8 = true});
  quantise(plan, model);
  return predict_planned(plan, model, trials, sways);
}

/// Returns the requested part of the data set. The default is all trials, or the validation half if a model was trained
/// on the other half. Throws Error as require_not_trained_on() does.
std::string split_of(const EvaluateOptions& options, std::span<const Model> models,
                     const dataset::TrialIdentity& data) {
  std::string split = options.split.empty() ? "all" : options.split;
  for (std::size_t i = 0; i < models.size() && options.split.empty(); ++i) {
    if (!trained_on(models[i].origin, data)) continue;
    split = "validation";
    if (!options.common.quiet)
      std::cerr << "note: " << (models.size() == 1 ? "the model" : model_name(options.models[i]))
                << " was trained on half of " << options.data << "; measured on the other, its validation"
                << (models[i].recalibration.known() ? ", on which its intervals were recalibrated\n" : "\n");
  }
  const Measured part = split == "all"        ? Measured::all
                        : split == "training" ? Measured::training
                                              : Measured::validation;
  for (const Model& model : models) require_not_trained_on(model.origin, data, part, options.data);
  return split;
}

/// Returns one of the figures of each parameter, by name.
template <class Figure>
Json of_each(const sim::ParameterTable& table, const Calibration& calibration, Figure figure) {
  std::vector<double> values;
  for (const ParameterCalibration& of : calibration.parameters) values.push_back(of.*figure);
  return by_parameter(table, values);
}

void add_calibration(Json& json, const sim::ParameterTable& table, const NetworkCalibration& found) {
  const auto add = [&](const std::string& key, double ParameterCalibration::*figure) {
    json[key] = found.figures.all.*figure;
    json[key + "_per_parameter"] = of_each(table, found.figures, figure);
  };
  add("coverage50", &ParameterCalibration::coverage50);
  add("coverage90", &ParameterCalibration::coverage90);
  add("predicted_variance", &ParameterCalibration::predicted_variance);
  json["log_score"] = number_or_null(found.figures.log_score);
  json["log_score_per_parameter"] = by_parameter(table, found.log_score_per_parameter);
}

std::string calibration_text(const sim::ParameterTable& table, const Evaluation& result,
                             const NetworkCalibration& found) {
  std::string text =
      format("  %-8s %8s %9s %9s %9s %10s\n", "", "MSE", "predicted", "50% cover", "90% cover", "log score");
  const auto line = [&](const std::string& what, double mse, const ParameterCalibration& of, double log_score) {
    text += format("  %-8s %8.4f %9.4f %8.1f%% %8.1f%% %10.3f\n", what.c_str(), mse, of.predicted_variance,
                   100.0 * of.coverage50, 100.0 * of.coverage90, log_score);
  };
  for (std::size_t p = 0; p < table.size(); ++p)
    line(table[p].name, result.mse_per_parameter[p], found.figures.parameters[p], found.log_score_per_parameter[p]);
  line("all", result.mse(), found.figures.all, found.figures.log_score);
  return text +
         "  predicted: predicted variance, which should equal the MSE; cover: coverage of these intervals;\n  log "
         "score: mean "
         "log density at the true values, in nats per parameter; 0 is the score of the ranges\n";
}

Evaluated evaluated(const EvaluateOptions& options, Model& model, const std::string& name,
                    const dataset::StoredDataset& stored, std::span<const int> chosen) {
  const dataset::Dataset& data = stored.about();
  const ForBody body = for_trials(model, name, data.protocol, options.data);
  if (const std::string other = noise_difference(model.protocol, data.protocol);
      !other.empty() && !options.common.quiet)
    std::cerr << "warning: " << options.data << ": " << other << '\n';
  std::vector<sim::Parameters> truth;
  for (const int i : chosen) truth.push_back(body.to_model(model, data.parameters[static_cast<std::size_t>(i)]));
  const auto sways = [&](std::span<const int> indices, const SwaySink& take) {
    std::vector<int> trials;
    for (const int index : indices) trials.push_back(chosen[static_cast<std::size_t>(index)]);
    stored.take(trials, [&](std::size_t place, std::span<const float> sway) { take(place, {sway, body.height}); });
  };
  const std::vector<float> outputs = compute_outputs(model, options.int8, static_cast<int>(chosen.size()), sways);
  return {name, model.parameters(), evaluate(model.targets, to_scores(model, outputs), truth),
          network_calibration(model, outputs, truth)};
}

Json to_json_object(const Evaluated& model) {
  Json json = evaluation_json(model.table, model.result);
  if (model.calibration) add_calibration(json, model.table, *model.calibration);
  return json;
}

/// Returns the first model's figures, and beside them the figures of all models.
Json to_json_object(const std::vector<Evaluated>& models) {
  Json json = to_json_object(models.front());
  for (const Evaluated& each : models) {
    Json line = to_json_object(each);
    line["model"] = each.name;
    json["models"].push_back(line);
  }
  return json;
}

std::string to_text(const Evaluated& model, const std::string& data) {
  const sim::ParameterTable& table = model.table;
  std::string text = format("%d trials of %s with %s\n", model.result.trials, data.c_str(), model.name.c_str()) +
                     format("MSE %.4f (mean over trials and %zu z-scored parameters; predicting the mean gives 1)\n",
                            model.result.mse(), table.size()) +
                     format("MATLAB's loss %.4f (half the sum over the %zu; predicting the mean gives %g)\n",
                            model.result.matlab_loss(), table.size(), 0.5 * static_cast<double>(table.size()));
  if (model.calibration) return text + calibration_text(table, model.result, *model.calibration);
  for (std::size_t p = 0; p < table.size(); ++p)
    text += format("  %-8s %.4f\n", table[p].name.c_str(), model.result.mse_per_parameter[p]);
  return text;
}

/// Returns one line per model.
std::string table_for(const std::vector<Evaluated>& models, const std::string& data) {
  std::size_t width = 5;
  bool any_calibration = false;
  for (const Evaluated& each : models) {
    width = std::max(width, each.name.size());
    any_calibration = any_calibration || each.calibration;
  }
  const auto named = [&](const std::string& name) { return "  " + name + std::string(width - name.size(), ' '); };
  std::string text = format("%s of %s; MSE of z-scored parameters, predicting the mean gives 1\n",
                            counted(models.front().result.trials, "trial").c_str(), data.c_str());
  text += named("model") + "      MSE";
  for (const sim::ParameterInfo& info : models.front().table) text += format(" %8s", info.name.c_str());
  text += any_calibration ? " predicted 90% cover log score\n" : "\n";
  for (const Evaluated& each : models) {
    text += named(each.name) + format(" %8.4f", each.result.mse());
    for (const double mse : each.result.mse_per_parameter) text += format(" %8.4f", mse);
    if (each.calibration) {
      const NetworkCalibration& found = *each.calibration;
      text += format(" %9.4f %8.1f%% %9.3f", found.figures.all.predicted_variance, 100.0 * found.figures.all.coverage90,
                     found.figures.log_score);
    }
    text += '\n';
  }
  return text;
}

void evaluate_models(EvaluateOptions options, const Command& command) {
  if (options.models.empty()) options.models.emplace_back();
  std::vector<Model> models;
  for (const std::string& path : options.models) models.push_back(model_or_built_in(path));
  const dataset::StoredDataset stored(options.data);
  const dataset::Dataset& data = stored.about();
  for (std::size_t i = 0; i < models.size(); ++i)
    static_cast<void>(for_trials(models[i], model_name(options.models[i]), data.protocol, options.data));
  const std::string split = split_of(options, models, dataset::trial_identity(stored));
  std::vector<int> chosen;
  for (int i = 0; i < data.trials(); ++i) {
    const bool training = data.split[static_cast<std::size_t>(i)] == 0;
    if (split == "all" || training == (split == "training")) chosen.push_back(i);
  }
  if (chosen.empty())
    throw Error(Code::trials_missing, options.data, "has no trial in its " + split + " half", "leave out --split");
  std::vector<Evaluated> all;
  for (std::size_t i = 0; i < models.size(); ++i)
    all.push_back(evaluated(options, models[i], model_name(options.models[i]), stored, chosen));
  if (!options.common.json) {
    std::cout << (all.size() == 1 ? to_text(all.front(), options.data) : table_for(all, options.data));
    return;
  }
  std::vector<std::string> inputs = options.models;
  inputs.push_back(options.data);
  Json result = to_json_object(all);
  add_call(result, record_call(command, inputs));
  std::cout << print_json(result) << '\n';
}

}  // namespace

void add_evaluate(const Command& program) {
  auto options = std::make_shared<EvaluateOptions>();
  const Command command = program.add_subcommand("evaluate", "Measure the error of one or more models on a data set");
  command.section("Input");
  command
      .add_option("--model", options->models,
                  "Evaluate this model file; repeat the option to compare several; default: the built-in model")
      .repeatable();
  command.add_option("--data", options->data, "Evaluate on this data set of decid dataset").required();
  command
      .add_option("--split", options->split,
                  "Use this part of the data set: all, training or validation; default: validation for the model's own "
                  "training set, else all")
      .one_of({"all", "training", "validation"});
  command.add_flag("--int8", options->int8, "Evaluate the 8-bit integer network that decid export c --int8 writes");
  command.footer(
      "Examples:\n"
      "  decid evaluate --data test.npz\n"
      "  decid evaluate --model mine.safetensors --data test.npz --json\n"
      "  decid evaluate --model a.safetensors --model b.safetensors --data test.npz --split all");
  run_with(command, options, true, evaluate_models);
}

}  // namespace decid::tools
