// decid compare: network, posterior, iterative fit, and iterative fit from the network's answer, on the same trials.
#include <algorithm>
#include <chrono>
#include <iostream>
#include <memory>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "dataset/npz/npz.hpp"
#include "identify/identify.hpp"
#include "tools/compare/comparison.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/interrupt.hpp"
#include "tools/decid/progress.hpp"
#include "tools/decid/ranks.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/report/comparison_page.hpp"
#include "tools/report/json/recording_json.hpp"

namespace decid::tools {
namespace {

struct CompareOptions {
  CommonOptions common;
  std::string model, controller, data, output, report;
  std::vector<double> sensor_noise_deg;
  int trials = 100;
  ComparisonSettings settings;
};

/// Returns the trials: the first trials of a data set, or new trials of the model's experiment.
dataset::Dataset trials_of(const CompareOptions& options, const Model& model) {
  using dataset::TrialIdentity;
  if (options.data.empty()) {
    require_not_trained_on(model.origin, {TrialIdentity::Kind::stream, options.settings.seed, {}}, Measured::all,
                           "test trials");
    dataset::DatasetRequest request;
    request.protocol = model.protocol.ideal();
    set_sensor_noise(request.protocol, options.sensor_noise_deg);
    request.protocol.validate();
    request.count = options.trials;
    request.seed = options.settings.seed;
    return dataset::generate(request);
  }
  if (!options.sensor_noise_deg.empty())
    throw Error(Code::setting_conflict, "--sensor-noise", "is for simulated trials; those of --data have their own",
                "leave one of them out");
  dataset::Dataset data = dataset::read_npz(options.data);
  require_same_experiment(model, model_name(options.model), data.protocol, options.data);
  require_not_trained_on(model.origin, dataset::trial_identity(data), Measured::all, options.data);
  const auto count = std::min(static_cast<std::size_t>(options.trials), data.parameters.size());
  data.parameters.resize(count);
  data.sway.resize(count * static_cast<std::size_t>(data.samples));
  return data;
}

/// Shares the trials among the ranks. Returns a method's answers at rank 0. `done`: answers of the methods before.
std::vector<MethodAnswer> answers_of(const Comparison& comparison, Method method, ProgressBar& bar, int done) {
  std::vector<MethodAnswer> answers(static_cast<std::size_t>(comparison.trials()));
  int at = 0;
  const auto answer_some = [&](std::size_t first, std::size_t last, const Give<MethodAnswer>& give) {
    parallel_for(static_cast<int>(last - first), [&](int place) {
      const std::size_t i = first + static_cast<std::size_t>(place);
      if (const auto answer = comparison.answer(method, static_cast<int>(i), interrupted)) give(i, *answer);
    });
  };
  const auto take = [&](std::size_t i, const MethodAnswer& answer) {
    answers[i] = answer;
    bar.update(done + ++at);
  };
  // A fit uses all threads; a posterior uses one.
  const std::size_t at_once = method == Method::posterior ? static_cast<std::size_t>(thread_count()) : 1;
  if (!share_out<MethodAnswer>(answers.size(), at_once, answer_some, take, interrupted))
    throw std::runtime_error(format("stopped at trial %d of %d", at, comparison.trials()));
  return answers;
}

ComparisonFigures compare(const CompareOptions& options) {
  const Model model = model_or_built_in(options.model);
  require_controller(options.controller, model.protocol, model_name(options.model));
  Comparison comparison(model, trials_of(options, model), options.settings);
  const int trials = comparison.trials();
  ComparisonFigures figures{
      .version = version,
      .model = model_name(options.model),
      .sha256 = nn::weights_sha256(model.network),
      .trials_from = options.data.empty() ? "seed " + std::to_string(options.settings.seed) : options.data,
      .protocol = comparison.protocol(),
      .trials = trials,
      .threads = thread_count(),
      .budget = options.settings.simulations,
      .starts = options.settings.starts,
      .methods = {comparison.network()}};
  catch_interrupt();
  ProgressBar bar("compare", "fits", 3LL * trials, options.common.quiet);
  int done = 0;
  for (const Method method : {Method::posterior, Method::fit, Method::fit_from_network}) {
    const auto start = std::chrono::steady_clock::now();
    const std::vector<MethodAnswer> answers = answers_of(comparison, method, bar, done);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (is_root()) std::ranges::move(comparison.figures(method, answers, seconds), std::back_inserter(figures.methods));
    done += trials;
  }
  return figures;
}

void run_compare(CompareOptions options, const Command& command) {
  options.settings.posterior.seed = options.settings.seed;
  options.settings.posterior.min_draws =
      std::min(options.settings.posterior.min_draws, options.settings.posterior.max_draws);
  refuse_same_file(options.output, {options.model, options.data});
  refuse_same_file(options.report, {options.model, options.data, options.output});
  for (const std::string& path : {options.output, options.report})
    if (!path.empty() && is_root()) PendingFile probe(path);
  const ComparisonFigures figures = compare(options);
  if (!is_root()) return;
  Call call = record_call(command, {options.model, options.data});
  call.seed = options.settings.seed;
  Json result = comparison_json(figures);
  add_call(result, call);
  const std::string json = print_json(result) + "\n";
  if (!options.output.empty()) write_file(options.output, json);
  if (!options.report.empty()) write_file(options.report, comparison_html(figures, call));
  std::cout << (options.common.json ? json : comparison_text(figures));
}

}  // namespace

void add_compare(const Command& program) {
  auto options = std::make_shared<CompareOptions>();
  const Command command = program.add_subcommand(
      "compare", "Compare network, posterior and iterative fits on trials with known parameters");
  command.section("Input");
  command.add_option("--trials", options->trials, "Compare the methods on this many trials").range(1, 100'000);
  add_seed_option(command, options->settings.seed, "Seed the trials and the fits");
  command
      .add_option("--sensor-noise", options->sensor_noise_deg,
                  "Add measurement noise with this standard deviation in degrees, or, for two numbers LOW HIGH, one "
                  "drawn between them for each trial; default: none")
      .values(1, 2);
  command.add_option("--data", options->data, "Use the trials of this data set instead of new ones");
  command.add_option("--model", options->model, "Use this model file; default: the built-in model");
  add_controller_of_model(command, options->controller);
  command.section("Advanced");
  command
      .add_option("--starts", options->settings.starts,
                  "Start the fit without a network this many times; the fit from the network's estimate starts once")
      .range(1, 100);
  command.add_option("--simulations", options->settings.simulations, "Simulate at most this many trials for each fit")
      .range(1LL, 1'000'000'000LL);
  command
      .add_option("--max-draws,--most-draws", options->settings.posterior.max_draws,
                  "Take at most this many draws per chain of a posterior")
      .range(8, 1'000'000);
  add_output_option(command, "-o,--output", options->output, Written::json, "Write the results to this JSON file");
  add_output_option(command, "--report", options->report, Written::html,
                    "Write the table and a chart to this HTML page");
  command.footer(
      "Examples:\n"
      "  decid compare --trials 100 --sensor-noise 0.02 --report compare.html\n"
      "  decid compare --data test.npz --model mine.safetensors -o compare.json\n"
      "  decid compare --trials 20 --starts 1 --simulations 6500");
  run_with(command, options, true, run_compare);
}

}  // namespace decid::tools
