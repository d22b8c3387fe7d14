// decid compare: network, posterior, iterative fit, and iterative fit from the network's answer, on the same trials.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <memory>
#include <span>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "dataset/npz/npz.hpp"
#include "identify/identify.hpp"
#include "identify/iterative/fit.hpp"
#include "identify/studies/comparison.hpp"
#include "posterior/posterior.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/interrupt.hpp"
#include "tools/decid/progress.hpp"
#include "tools/decid/ranks.hpp"
#include "tools/report/comparison_page.hpp"

namespace decid::tools {
namespace {

/// Standard deviation of the prior about the network's answer, as a fraction of the ranges. On trials of a seed behind
/// no published figure, 0.08 had smaller errors than 0.15, and both had smaller errors than no prior.
constexpr double network_spread = 0.08;

struct CompareOptions {
  CommonOptions common;
  std::string model, controller, data, output, report;
  std::vector<double> sensor_noise_deg;
  int trials = 100, starts = 2;
  std::uint64_t seed = 2026;
  long long simulations = iterative::Settings{}.simulations;
  posterior::Settings posterior;
};

/// A trial's posterior.
struct Sampled {
  sim::Parameters mean, deviation;
  double leapfrog_steps = 0.0;
  template <class Archive>
  void archive(Archive& a) {
    a(mean, deviation, leapfrog_steps);
  }
};
/// A trial's iterative fit; ratio: the sum of its squared errors over the squared standard errors.
struct Fitted {
  sim::Parameters mean, likeliest;
  double simulations = 0.0, ratio = 0.0;
  template <class Archive>
  void archive(Archive& a) {
    a(mean, likeliest, simulations, ratio);
  }
};

/// Returns the trials: the first trials of a data set, or new trials of the model's experiment.
dataset::Dataset trials_of(const CompareOptions& options, const Model& model) {
  using dataset::TrialIdentity;
  if (options.data.empty()) {
    require_not_trained_on(model.origin, {TrialIdentity::Kind::stream, options.seed, {}}, Measured::all,
                           "fresh trials");
    dataset::DatasetRequest request;
    request.protocol = model.protocol.ideal();
    if (!options.sensor_noise_deg.empty())
      request.protocol.noise.sensor = {options.sensor_noise_deg.front(), options.sensor_noise_deg.back()};
    request.protocol.validate();
    request.count = options.trials;
    request.seed = options.seed;
    return dataset::generate(request);
  }
  if (!options.sensor_noise_deg.empty())
    throw Error("--sensor-noise", "is for fresh trials; those of --data have their own", "leave one of them out");
  dataset::Dataset data = dataset::read_npz(options.data);
  require_same_experiment(model, model_name(options.model), data.protocol, options.data);
  require_not_trained_on(model.origin, dataset::identity_of(data), Measured::all, options.data);
  const auto count = std::min(static_cast<std::size_t>(options.trials), data.parameters.size());
  data.parameters.resize(count);
  data.sway.resize(count * static_cast<std::size_t>(data.samples));
  return data;
}

recording::Trial trial_of(const dataset::Dataset& data, int index) {
  const std::span<const float> sway_rad = data.trial(index);
  return recording::trial_of({sway_rad.begin(), sway_rad.end()});
}

struct Stopwatch {
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); }
};

ComparisonFigures compare(const CompareOptions& options) {
  iterative::check_budget({options.simulations, options.seed}, static_cast<std::size_t>(options.starts));
  const Model model = model_or_built_in(options.model);
  require_controller(options.controller, model.protocol, model_name(options.model));
  const dataset::Dataset data = trials_of(options, model);
  const int trials = data.trials();
  ComparisonFigures figures{.version = version,
                            .model = model_name(options.model),
                            .sha256 = nn::weights_sha256(model.network),
                            .trials_from = options.data.empty() ? "seed " + std::to_string(options.seed) : options.data,
                            .protocol = data.protocol,
                            .trials = trials,
                            .threads = thread_count(),
                            .budget = options.simulations,
                            .starts = options.starts,
                            .methods = {}};
  const auto add = [&](const char* name, const char* description, const std::vector<sim::Parameters>& estimates,
                       double simulations, double seconds) {
    figures.methods.push_back(errors_of(name, description, estimates, data.parameters, model.targets.deviation));
    figures.methods.back().simulations = simulations / trials;
    figures.methods.back().seconds = seconds / trials;
  };

  Identifier identifier(model);
  const Stopwatch network_time;
  std::vector<sim::Parameters> network;
  for (int i = 0; i < trials; ++i)  // one at a time, as recordings come
    network.push_back(identifier.estimate({trial_of(data, i)}).front().parameters);
  add("network", "The network's answer, no simulation", network, 0, network_time.seconds());

  catch_interrupt();
  ProgressBar bar("compare", "fits", 3LL * trials, options.common.quiet);
  int at = 0;  // the trial
  const auto stop_unless = [&](bool goes_on) {
    if (!goes_on) throw std::runtime_error(format("stopped at trial %d of %d", at, trials));
  };
  const auto squared_ratio = [&](int trial, const sim::Parameters& estimate, const sim::Parameters& error) {
    double sum = 0;
    for (std::size_t p = 0; p < estimate.size(); ++p) {
      const double difference = estimate[p] - data.parameters[static_cast<std::size_t>(trial)][p];
      sum += difference * difference / (error[p] * error[p]);
    }
    return sum;
  };
  const auto state_ratio = [&](double ratio2) {
    figures.methods.back().error_per_standard_error =
        std::sqrt(ratio2 / (static_cast<double>(trials) * static_cast<double>(data.protocol.parameters().size())));
  };

  {
    const posterior::Density density(data.protocol, {.start_s = 0.0, .gain = 0.0});
    const Stopwatch time;
    const auto parameters = data.protocol.parameters().size();
    std::vector<sim::Parameters> means(static_cast<std::size_t>(trials), sim::Parameters(parameters)),
        deviations = means;
    std::vector<double> leapfrog_steps(means.size());
    const auto sample_some = [&](std::size_t first, std::size_t last, const Give<Sampled>& give) {
      parallel_for(static_cast<int>(last - first), [&](int place) {
        const std::size_t i = first + static_cast<std::size_t>(place);
        const posterior::Posterior found =
            posterior::sample(density, density.observe(data.trial(static_cast<int>(i))), options.posterior, {},
                              [](const posterior::Progress&) { return !interrupted(); });
        if (interrupted()) return;
        Sampled sampled{sim::Parameters(parameters), sim::Parameters(parameters),
                        static_cast<double>(found.leapfrog_steps())};
        for (std::size_t p = 0; p < parameters; ++p) {
          sampled.mean[p] = found.mean(static_cast<int>(p));
          sampled.deviation[p] = found.deviation(static_cast<int>(p));
        }
        give(i, sampled);
      });
    };
    const auto take = [&](std::size_t i, const Sampled& sampled) {
      bar.update(++at);
      leapfrog_steps[i] = sampled.leapfrog_steps;
      means[i] = sampled.mean;
      deviations[i] = sampled.deviation;
    };
    stop_unless(
        share_out<Sampled>(means.size(), static_cast<std::size_t>(thread_count()), sample_some, take, interrupted));
    double gradients = 0, ratio2 = 0;
    for (int i = 0; i < trials; ++i) {
      const auto place = static_cast<std::size_t>(i);
      ratio2 += squared_ratio(i, means[place], deviations[place]);
      gradients += leapfrog_steps[place];
    }
    add("posterior", "Mean of draws from the posterior (decid fit); simulations are its gradients", means, gradients,
        time.seconds());
    state_ratio(ratio2);
  }

  const sim::Simulator simulator(data.protocol);
  const sim::ParameterTable table = data.protocol.ranges();
  const auto fit_all = [&](bool from_network, const char* mean_name, const char* mean_text, const char* likeliest_name,
                           const char* likeliest_text) {
    const auto starts_of = [&](int trial) {
      std::vector<iterative::Start> starts;
      if (from_network) {
        starts.push_back({network[static_cast<std::size_t>(trial)], network_spread, network_spread});
        return starts;
      }
      starts.push_back(iterative::middle_start(table));
      while (starts.size() < static_cast<std::size_t>(options.starts))
        starts.push_back(iterative::random_start(table, options.seed, starts.size()));
      return starts;
    };
    const Stopwatch time;
    const std::size_t parameters = table.size();
    std::vector<sim::Parameters> means(static_cast<std::size_t>(trials), sim::Parameters(parameters)),
        likeliest = means;
    std::vector<double> ratios(means.size());
    double simulations = 0, ratio2 = 0;
    at = 0;
    const auto fit_one = [&](std::size_t i, std::size_t, const Give<Fitted>& give) {
      const int trial = static_cast<int>(i);
      const iterative::Result found =
          iterative::fit(simulator, data.trial(trial), starts_of(trial), {options.simulations, options.seed});
      if (!interrupted())
        give(i, {found.parameters, found.likeliest, static_cast<double>(found.simulations),
                 squared_ratio(trial, found.parameters, found.standard_error)});
    };
    const auto take = [&](std::size_t i, const Fitted& fitted) {
      simulations += fitted.simulations;
      ratios[i] = fitted.ratio;
      means[i] = fitted.mean;
      likeliest[i] = fitted.likeliest;
      bar.update((from_network ? 2 : 1) * trials + ++at);
    };
    stop_unless(share_out<Fitted>(means.size(), 1, fit_one, take, interrupted));
    for (const double ratio : ratios) ratio2 += ratio;
    const double seconds = time.seconds();
    add(likeliest_name, likeliest_text, likeliest, simulations, seconds);
    add(mean_name, mean_text, means, simulations, seconds);
    state_ratio(ratio2);
  };
  fit_all(false, "iterative fit", "Iterative fit from the middle of the ranges, mean of the likely parameters",
          "iterative fit, likeliest", "The same fit, the single likeliest parameters: what a fit usually returns");
  fit_all(true, "iterative fit from network", "Iterative fit from the network's answer, mean of the likely parameters",
          "iterative fit from network, likeliest", "The same fit, the single likeliest parameters");
  return figures;
}

void run_compare(const CompareOptions& options) {
  refuse_same_file(options.output, {options.model, options.data});
  refuse_same_file(options.report, {options.model, options.data, options.output});
  for (const std::string& path : {options.output, options.report})
    if (!path.empty() && is_root()) PendingFile probe(path);
  const ComparisonFigures figures = compare(options);
  if (!is_root()) return;
  const std::string json = print_json(comparison_json(figures)) + "\n";
  if (!options.output.empty()) write_file(options.output, json);
  if (!options.report.empty()) write_file(options.report, comparison_html(figures));
  std::cout << (options.common.json ? json : comparison_text(figures));
}

}  // namespace

void add_compare(const Command& program) {
  auto options = std::make_shared<CompareOptions>();
  const Command command = program.add_subcommand(
      "compare", "Compare network, posterior and iterative fits on trials with known parameters");
  command.section("Input");
  command.add_option("--trials", options->trials, "Compare the methods on this many trials")
      .show_default()
      .range(1, 100'000);
  add_seed_option(command, options->seed, "Seed the trials and the fits");
  command
      .add_option("--sensor-noise", options->sensor_noise_deg,
                  "Add measurement noise with this standard deviation in degrees, or one drawn from LOW HIGH for each "
                  "trial; default: none")
      .values(1, 2);
  command.add_option("--data", options->data, "Use the trials of this data set instead of new ones");
  command.add_option("--model", options->model, "Use this model file; default: the built-in model");
  add_controller_of_model(command, options->controller);
  command.section("Advanced");
  command
      .add_option("--starts", options->starts,
                  "Start the fit without a network this many times; the fit from the network's estimate starts once")
      .show_default()
      .range(1, 100);
  command.add_option("--simulations", options->simulations, "Simulate at most this many trials for each fit")
      .show_default()
      .range(1LL, 1'000'000'000LL);
  command
      .add_option("--max-draws,--most-draws", options->posterior.max_draws,
                  "Take at most this many draws per chain of a posterior")
      .show_default()
      .range(8, 1'000'000);
  add_output_option(command, "-o,--output", options->output, Written::json, "Write the results to this JSON file");
  add_output_option(command, "--report", options->report, Written::html,
                    "Write the table and a chart to this HTML page");
  add_common_options(command, options->common, true);
  command.footer(
      "Examples:\n"
      "  decid compare --trials 100 --sensor-noise 0.02 --report compare.html\n"
      "  decid compare --data test.npz --model mine.safetensors -o compare.json\n"
      "  decid compare --trials 20 --starts 1 --simulations 6500");
  command.callback([options] {
    options->posterior.seed = options->seed;
    options->posterior.min_draws = std::min(options->posterior.min_draws, options->posterior.max_draws);
    apply(options->common);
    run_compare(*options);
  });
}

}  // namespace decid::tools
