// decid fit: recordings in, parameters by iterative simulation out.
#include <iostream>
#include <memory>

#include "base/file.hpp"
#include "dataset/protocol_json.hpp"
#include "tools/command.hpp"
#include "tools/fit.hpp"

namespace decid::tools {
namespace {

struct Options {
  CommonOptions common;
  std::vector<std::string> files;
  std::string model, protocol, column, unit, start = "network", output;
  std::optional<double> rate;
  FitRequest request;
};

void run_fit(const Options& options) {
  dataset::RecordingOptions recording;
  recording.column = options.column;
  recording.rate_hz = options.rate;
  if (!options.unit.empty()) recording.unit = options.unit == "rad" ? dataset::Unit::radian : dataset::Unit::degree;
  std::vector<std::string> inputs = options.files;
  inputs.push_back(options.model);
  inputs.push_back(options.protocol);
  refuse_same_file(options.output, inputs);
  if (!options.output.empty()) PendingFile probe(options.output);  // told before the work, not after

  FitRequest request = options.request;
  request.start = options.start == "network"  ? StartKind::network
                  : options.start == "middle" ? StartKind::middle
                                              : StartKind::random;
  Model model = model_or_built_in(options.model);
  const sim::Protocol protocol = options.protocol.empty() ? model.protocol : dataset::load_protocol(options.protocol);
  const std::vector<std::filesystem::path> files(options.files.begin(), options.files.end());
  const std::vector<Fitted> all = fit_recordings(&model, protocol, files, recording, request);
  const std::string json = fits_json(model_name(options.model), all);
  if (!options.output.empty()) write_file(options.output, json);
  if (options.common.json)
    std::cout << json;
  else if (!options.common.quiet)
    std::cout << fits_text(all);
}

}  // namespace

void add_fit(CLI::App& program) {
  auto options = std::make_shared<Options>();
  CLI::App* command = program.add_subcommand("fit", "Fit recordings by iterative simulation, the slow way");
  command->add_option("recordings", options->files, "CSV files: a column of sway, usually one of time")->required();
  command->add_option("--start", options->start, "Where the first search starts: network, middle or random")
      ->capture_default_str()
      ->check(CLI::IsMember({"network", "middle", "random"}));
  command->add_option("--starts", options->request.starts, "Searches; those after the first start at random places")
      ->capture_default_str()
      ->check(CLI::Range(1, 100));
  command->add_option("--simulations", options->request.settings.simulations, "Trials to simulate a recording, at most")
      ->capture_default_str()
      ->check(CLI::Range(1LL, 1'000'000'000LL));
  command->add_option("--model", options->model,
                      "Model file for the start and the protocol; default: the built-in model");
  command->add_option("--protocol", options->protocol, "default, short, or a JSON file; default: the model's");
  command->add_option("--column", options->column, "Sway column, by name or number from 1; default: found by name");
  command->add_option("--unit", options->unit, "deg or rad; default: from the column's name, else degrees")
      ->check(CLI::IsMember({"deg", "rad"}));
  command->add_option("--rate", options->rate, "Sample rate in Hz, if there is no time column or it is wrong")
      ->check(CLI::Range(1.0, 100000.0));
  command->add_option("--seed", options->request.settings.seed, "Of the searches and of the noise that they simulate")
      ->capture_default_str();
  command->add_option("-o,--output", options->output, "JSON file to write");
  add_common_options(*command, options->common, true);
  command->footer("Example: decid fit recording.csv --start network --simulations 20000 -o result.json");
  command->callback([options] {
    apply(options->common);
    run_fit(*options);
  });
}

}  // namespace decid::tools
