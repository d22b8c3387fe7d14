// decid fit: recordings in, parameters by iterative simulation out.
#include <iostream>
#include <memory>
#include <optional>

#include "base/file.hpp"
#include "dataset/recording/protocol_file.hpp"
#include "identify/fit/fit_recordings.hpp"
#include "sim/protocol_json.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/fit_results.hpp"
#include "tools/decid/progress.hpp"
#include "tools/decid/recording_flags.hpp"

namespace decid::tools {
namespace {

struct FitOptions {
  CommonOptions common;
  RecordingFlags recordings;
  std::string model, protocol, start = "network", output;
  FitRequest request;
};

void run_fit(const FitOptions& options) {
  catch_interrupt();
  ReadOptions reading = options.recordings.read_options();
  std::vector<std::string> inputs = options.recordings.files;
  inputs.push_back(options.model);
  std::optional<sim::Protocol> given;
  if (!options.protocol.empty()) given = dataset::load_protocol(options.protocol, &inputs);
  refuse_same_file(options.output, inputs);
  if (!options.output.empty()) PendingFile probe(options.output);  // reports an unwritable place before the work

  FitRequest request = options.request;
  request.start = options.start == "network"  ? StartKind::network
                  : options.start == "middle" ? StartKind::middle
                                              : StartKind::random;
  const Model model = model_or_built_in(options.model);
  const sim::Protocol protocol = given.value_or(model.protocol);
  reading.truth = options.recordings.known(protocol.parameters());
  const auto files = static_cast<long long>(options.recordings.files.size());
  FittedRecordings all;
  {
    ProgressBar bar("fit", "recordings", files, options.common.quiet || files == 1);
    all = fit_recordings(&model, protocol, options.recordings.paths(), reading, request, [&](std::size_t done) {
      bar.update(static_cast<long long>(done));
      return !interrupted();
    });
  }
  if (static_cast<long long>(all.fits.size()) < files)
    throw std::runtime_error("stopped after " + std::to_string(all.fits.size()) + " of " + std::to_string(files) +
                             " recordings; nothing was written");
  refuse_alone(all.identified.recordings);
  const std::string json = fits_json(model_name(options.model), all);
  if (!options.output.empty()) write_file(options.output, json);
  std::cout << (options.common.json ? json : fits_text(all));
  tell_errors("fit", all.identified.recordings);
}

}  // namespace

void add_fit(const Command& program) {
  auto options = std::make_shared<FitOptions>();
  const Command command = program.add_subcommand("fit", "Fit recordings by iterative simulation, the slow way");
  command.add_option("--start", options->start, "Where the first search starts: network, middle or random")
      .show_default()
      .one_of({"network", "middle", "random"});
  command.add_option("--starts", options->request.starts, "Searches; those after the first start at random places")
      .show_default()
      .range(1, 100);
  command.add_option("--simulations", options->request.settings.simulations, "Trials to simulate a recording, at most")
      .show_default()
      .range(1LL, 1'000'000'000LL);
  command.add_option("--model", options->model,
                     "Model file for the start and the protocol; default: the built-in model");
  command.add_option("--protocol", options->protocol, "default, short, or a JSON file; default: the model's");
  add_recording_flags(command, options->recordings, "--begin");
  add_truth_option(command, options->recordings);
  add_seed_option(command, options->request.settings.seed, "Of the searches and of the noise that they simulate");
  add_output_option(command, options->output, "JSON file to write");
  add_common_options(command, options->common, true);
  command.footer("Example: decid fit recording.csv --start network --simulations 20000 -o result.json");
  command.callback([options] {
    apply(options->common);
    run_fit(*options);
  });
}

}  // namespace decid::tools
