// decid fit: recordings or a published frequency response in, the posterior of their controllers out.
#include <algorithm>
#include <iostream>
#include <memory>
#include <numeric>
#include <optional>

#include "base/error.hpp"
#include "base/file.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "dataset/recording/protocol_file.hpp"
#include "identify/fit_recordings.hpp"
#include "sim/protocol_json.hpp"
#include "sim/segments.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/fit_frf.hpp"
#include "tools/decid/fit_results.hpp"
#include "tools/decid/interrupt.hpp"
#include "tools/decid/progress.hpp"
#include "tools/decid/recording_flags.hpp"
#include "tools/report/fit_page.hpp"

namespace decid::tools {
namespace {

struct FitOptions {
  CommonOptions common;
  RecordingFlags recordings;
  std::string model, protocol, output, draws, table, report;
  std::optional<double> amplitude_deg, prior_error;
  FitRequest request;
};

/// Options of recordings alone besides how they are read, and those of a frequency response alone.
constexpr const char* of_recordings[] = {"recordings",    "--model",      "--prior-start",
                                         "--prior-noise", "--most-draws", "--report"};
constexpr const char* of_tables[] = {"--amplitude", "--prior-error"};

/// Throws Error for options that do not go with what is to be fitted.
void check_kind(const FitOptions& options, const Command& command) {
  const bool is_table = !options.table.empty();
  if (!is_table && options.recordings.files.empty())
    throw Error("fit", "neither a recording nor a frequency response is named",
                "name CSV or MAT-files, or a table with --frf");
  const auto refuse = [&](const char* option) {
    if (command.count(option) == 0) return;
    if (is_table && std::string(option) == "recordings")
      throw Error("--frf", "does not go with recordings", "fit them in a call of their own");
    throw Error(option, is_table ? "is not for --frf" : "is for --frf alone", "leave it out");
  };
  if (is_table) std::ranges::for_each(of_recordings, refuse);
  if (is_table) std::ranges::for_each(reading_options, refuse);
  if (!is_table) std::ranges::for_each(of_tables, refuse);
}

/// Throws Error if an output would replace an input or another output, or cannot be written.
void check_outputs(const FitOptions& options, std::vector<std::string> inputs) {
  refuse_same_file(options.output, inputs);
  inputs.push_back(options.output);
  refuse_same_file(options.draws, inputs);
  inputs.push_back(options.draws);
  refuse_same_file(options.report, inputs);
  for (const std::string& path : {options.output, options.draws, options.report})
    if (!path.empty()) PendingFile probe(path);  // reports an unwritable place before the work
}

/// The protocol that was asked for, with the subject's body if one was described.
sim::Protocol protocol_of(const FitOptions& options, sim::Protocol protocol) {
  if (const std::optional<sim::Body> body = options.recordings.body()) protocol.experiment.body = *body;
  if (options.amplitude_deg) {
    if (!std::holds_alternative<sim::Sequence>(protocol.experiment.stimulus))
      throw Error("--amplitude", "protocol '" + protocol.name + "' plays no ternary sequence, the tilt that it scales",
                  "leave it out, and give the amplitudes in the protocol's file");
    protocol.sequence().amplitude_deg = *options.amplitude_deg;
  }
  protocol.validate();
  return protocol;
}

void run_table(const FitOptions& options) {
  std::vector<std::string> inputs{options.table};
  const sim::Protocol named = dataset::load_protocol(options.protocol.empty() ? "default" : options.protocol, &inputs);
  check_outputs(options, inputs);
  FrfFit asked{.table = options.table,
               .output = options.output,
               .draws = options.draws,
               .protocol = protocol_of(options, named),
               .truth = {},
               .priors = {.gain = options.request.priors.gain, .error = options.prior_error},
               .walkers = {.seed = options.request.settings.seed},
               .json = options.common.json};
  asked.truth = options.recordings.known(asked.protocol.parameters());
  run_frf_fit(asked);
}

void run_fit(const FitOptions& options) {
  ReadOptions reading = options.recordings.read_options();
  std::vector<std::string> inputs = options.recordings.files;
  inputs.push_back(options.model);
  std::optional<sim::Protocol> given;
  if (!options.protocol.empty()) given = dataset::load_protocol(options.protocol, &inputs);
  check_outputs(options, inputs);
  const Model model = model_or_built_in(options.model);
  const sim::Protocol protocol = protocol_of(options, given.value_or(model.protocol));
  reading.truth = options.recordings.known(protocol.parameters());
  reading.body = options.recordings.body();
  // A protocol of one's own may describe it.
  if (!reading.body && given && given->experiment.body != sim::Body{}) reading.body = given->experiment.body;
  const auto files = static_cast<long long>(options.recordings.files.size());
  constexpr long long parts = 100;  // of a recording, for the bar
  FittedRecordings all;
  catch_interrupt();
  {
    ProgressBar bar("fit", "%", parts * files, options.common.quiet);
    std::vector<double> done(options.recordings.files.size());  // of each
    all = fit_recordings(
        &model, protocol, options.recordings.paths(), reading, options.request,
        [&](std::size_t recording, const posterior::Progress& progress) {
          done[recording] = progress.done;
          bar.update(static_cast<long long>(parts * std::accumulate(done.begin(), done.end(), 0.0)),
                     progress.rhat > 0.0 ? format("%s, R-hat %.2f", progress.stage, progress.rhat) : progress.stage);
          return !interrupted();
        });
  }
  recognise_tables(all.identified.recordings);
  refuse_alone(all.identified.recordings);
  const std::string json = fits_json(model_name(options.model), all);
  if (!options.output.empty()) write_file(options.output, json);
  if (!options.draws.empty()) write_draws(options.draws, all);
  if (!options.report.empty()) write_file(options.report, fit_report_html(version, options.request, all));
  std::cout << (options.common.json ? json : fits_text(all));
  if (interrupted())
    throw std::runtime_error(
        format("stopped at recording %zu of %lld; what was drawn until then was written", all.fits.size(), files));
  tell_errors("fit", all.identified.recordings);
}

}  // namespace

void add_fit(const Command& program) {
  auto options = std::make_shared<FitOptions>();
  const Command command = program.add_subcommand(
      "fit", "Sample what recordings say: the posterior of the parameters, slower than identify");
  add_recording_flags(command, options->recordings);
  add_truth_option(command, options->recordings);
  command.add_option("--frf", options->table,
                     "In place of recordings, a frequency response: a table of frequency_hz, gain, phase_deg and, if "
                     "known, sd, ci95, radius95 or coherence and cycles");
  command
      .add_option("--amplitude", options->amplitude_deg,
                  "With --frf: peak to peak of the tilt in degrees; default: the protocol's")
      .range(1e-3, 20.0);
  add_body_options(command, options->recordings);
  command.add_option("--protocol", options->protocol, "default, short, or a JSON file; default: the model's");
  command.add_option("--model", options->model,
                     "Model file for the protocol, and for an answer where chains disagree; default: the built-in one");
  command
      .add_option("--prior-start", options->request.priors.start_s,
                  "The recording may start so many seconds before or after the protocol; 0: at it. With --tilt-column "
                  "it is known")
      .show_default()
      .range(0.0, 0.5);
  command
      .add_option("--prior-gain", options->request.priors.gain,
                  "The sway may be scaled by 1 +- this, say by a wrong height of a marker; 0: it is not")
      .show_default()
      .range(0.0, 0.5);
  command
      .add_option("--prior-noise", options->request.priors.sensor_noise_deg,
                  "The sensor's noise in degrees, to a factor of 20")
      .show_default()
      .range(1e-6, 10.0);
  command
      .add_option("--prior-error", options->prior_error,
                  "With --frf: the table's errors beyond its confidence over the response, to a factor of 3; default: "
                  "0.01, or 0.05 without confidence")
      .range(0.0, 1.0);
  command.add_option("--most-draws", options->request.settings.most_draws, "Of each chain; fewer if they are enough")
      .show_default()
      .range(8, 1'000'000);
  add_seed_option(command, options->request.settings.seed, "Of the chains");
  add_output_option(command, "-o,--output", options->output, Written::json, "JSON file to write");
  add_output_option(command, "--draws", options->draws, Written::npz, "All draws as arrays, for NumPy (.npz)");
  add_output_option(command, "--report", options->report, Written::html,
                    "HTML report to write: one page that opens offline");
  add_common_options(command, options->common, true);
  command.footer("Example: decid fit recording.csv --mass 70 --height 1.75 -o result.json --report report.html");
  command.callback([options, command] {
    check_kind(*options, command);
    options->request.settings.least_draws =
        std::min(options->request.settings.least_draws, options->request.settings.most_draws);
    apply(options->common);
    if (options->table.empty()) return run_fit(*options);
    run_table(*options);
  });
}

}  // namespace decid::tools
