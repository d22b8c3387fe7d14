// decid evaluate: a model's error on a data set.
#include <iostream>
#include <memory>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"
#include "dataset/npz/npz.hpp"
#include "identify/calibration.hpp"
#include "identify/for_body.hpp"
#include "identify/prediction.hpp"
#include "identify/training/training.hpp"
#include "tools/decid/command.hpp"
#include "tools/firmware/quantise.hpp"
#include "tools/report/parameters_json.hpp"

namespace decid::tools {
namespace {

struct EvaluateOptions {
  CommonOptions common;
  std::string model, data, split;
  bool int8 = false;
};

/// The outputs of the model's network, or of the one in 8-bit integers that a firmware would have.
std::vector<float> outputs_of(Model& model, bool int8, int trials, const Sways& sways) {
  if (!int8) return predict(model, trials, 64, sways);
  FirmwarePlan plan = plan_firmware(model, {.int8 = true});
  quantise(plan, model);
  return predict_planned(plan, model, trials, sways);
}

/// The part that was asked for, if the model was not trained on it; the other half of its own data set if none was.
std::string split_of(const EvaluateOptions& options, const Model& model, const dataset::TrialIdentity& data) {
  const Origin& origin = model.origin;
  std::string split = options.split.empty() ? "all" : options.split;
  if (options.split.empty() && trained_on(origin, data)) {
    split = "validation";
    if (!options.common.quiet)
      std::cerr << "note: the model was trained on half of " << options.data
                << "; measured on the other, its validation"
                << (model.recalibration.known() ? ", on which its intervals were recalibrated\n" : "\n");
  }
  const Measured part = split == "all"        ? Measured::all
                        : split == "training" ? Measured::training
                                              : Measured::validation;
  require_not_trained_on(origin, data, part, options.data);
  return split;
}

/// One of the figures of each parameter, by name.
template <class Figure>
Json of_each(const sim::ParameterTable& table, const Calibration& calibration, Figure figure) {
  std::vector<double> values;
  for (const ParameterCalibration& of : calibration.parameters) values.push_back(of.*figure);
  return by_parameter(table, values);
}

void add_promises(Json& json, const sim::ParameterTable& table, const NetworkCalibration& found) {
  const auto add = [&](const std::string& key, double ParameterCalibration::*figure) {
    json[key] = found.figures.all.*figure;
    json[key + "_per_parameter"] = of_each(table, found.figures, figure);
  };
  add("covered50", &ParameterCalibration::covered50);
  add("covered90", &ParameterCalibration::covered90);
  add("promised", &ParameterCalibration::promised);
  json["log_score"] = number_or_null(found.figures.log_score);
  json["log_score_per_parameter"] = by_parameter(table, found.log_score_per_parameter);
}

std::string promises_text(const sim::ParameterTable& table, const Evaluation& result, const NetworkCalibration& found) {
  std::string text = format("  %-8s %8s %9s %9s %9s %10s\n", "", "MSE", "promised", "in 50 %", "in 90 %", "log score");
  const auto line = [&](const std::string& what, double mse, const ParameterCalibration& of, double log_score) {
    text += format("  %-8s %8.4f %9.4f %8.1f%% %8.1f%% %10.3f\n", what.c_str(), mse, of.promised, 100.0 * of.covered50,
                   100.0 * of.covered90, log_score);
  };
  for (std::size_t p = 0; p < table.size(); ++p)
    line(table[p].name, result.mse_per_parameter[p], found.figures.parameters[p], found.log_score_per_parameter[p]);
  line("all", result.mse(), found.figures.all, found.figures.log_score);
  return text +
         "  promised: mean variance, to be as large as the MSE; in 50 %, in 90 %: share of the truths in these "
         "intervals;\n  log score: mean log density at the truth, of shares of the ranges, in nats a parameter; 0 "
         "knows only the ranges\n";
}

void evaluate_model(const EvaluateOptions& options) {
  Model model = model_or_built_in(options.model);
  const dataset::StoredDataset stored(options.data);
  const dataset::Dataset& data = stored.about();
  const ForBody body = for_trials(model, model_name(options.model), data.protocol, options.data);
  const dataset::TrialIdentity identity = dataset::identity_of(stored);
  const std::string split = split_of(options, model, identity);
  if (const std::string other = noise_difference(model.protocol, data.protocol);
      !other.empty() && !options.common.quiet)
    std::cerr << "warning: " << options.data << ": " << other << '\n';
  std::vector<int> chosen;
  std::vector<sim::Parameters> truth;
  for (int i = 0; i < data.trials(); ++i) {
    const bool training = data.split[static_cast<std::size_t>(i)] == 0;
    if (split == "all" || training == (split == "training")) {
      chosen.push_back(i);
      truth.push_back(body.to_model(model, data.parameters[static_cast<std::size_t>(i)]));
    }
  }
  if (chosen.empty()) throw Error(options.data, "has no trial in its " + split + " half", "leave out --split");
  const auto sways = [&](std::span<const int> indices, const TakeSway& take) {
    parallel_for(static_cast<int>(indices.size()), [&](int i) {
      thread_local std::vector<float> sway;
      sway.resize(static_cast<std::size_t>(data.samples));
      const auto place = static_cast<std::size_t>(i);
      stored.read(chosen[static_cast<std::size_t>(indices[place])], sway);
      take(place, {sway, body.height});
    });
  };
  const std::vector<float> outputs = outputs_of(model, options.int8, static_cast<int>(chosen.size()), sways);
  const Evaluation result = evaluate(model.targets, scores_of(model, outputs), truth);
  const std::optional<NetworkCalibration> promises = network_calibration(model, outputs, truth);
  if (options.common.json) {
    Json json = evaluation_json(model.parameters(), result);
    if (promises) add_promises(json, model.parameters(), *promises);
    std::cout << json.dump(2) << '\n';
    return;
  }
  const sim::ParameterTable& table = model.parameters();
  std::cout << format("%d trials of %s with %s\n", result.trials, options.data.c_str(),
                      model_name(options.model).c_str())
            << format("MSE %.4f (mean over trials and %zu z-scored parameters; predicting the mean gives 1)\n",
                      result.mse(), table.size())
            << format("MATLAB's loss %.4f (half the sum over the %zu; predicting the mean gives %g)\n",
                      result.matlab_loss(), table.size(), 0.5 * static_cast<double>(table.size()));
  if (promises) {
    std::cout << promises_text(table, result, *promises);
    return;
  }
  for (std::size_t p = 0; p < table.size(); ++p)
    std::cout << format("  %-8s %.4f\n", table[p].name.c_str(), result.mse_per_parameter[p]);
}

}  // namespace

void add_evaluate(const Command& program) {
  auto options = std::make_shared<EvaluateOptions>();
  const Command command = program.add_subcommand("evaluate", "Measure a model's error on a data set");
  command.add_option("--model", options->model, "Model file; default: the built-in model");
  command.add_option("--data", options->data, "Data set made by decid dataset").required();
  command
      .add_option(
          "--split", options->split,
          "all, training or validation; default: all, or of the data set that the model was trained on, validation")
      .one_of({"all", "training", "validation"});
  command.add_flag("--int8", options->int8, "Of the network in 8-bit integers that decid export c --int8 writes");
  add_common_options(command, options->common, true);
  command.footer("Example: decid evaluate --model model.safetensors --data fresh.npz --json");
  command.callback([options] {
    apply(options->common);
    evaluate_model(*options);
  });
}

}  // namespace decid::tools
