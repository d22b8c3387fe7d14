// decid study: a model compared with the paper, in figures and numbers, and the accuracy of its estimates.
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/number.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "identify/study/study_results.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/recording_flags.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/report/comparison_page.hpp"
#include "tools/report/json/recording_json.hpp"
#include "tools/report/study_page.hpp"

namespace decid::tools {
namespace {

struct StudyOptions {
  CommonOptions common;
  RecordingFlags reading;
  std::string model, controller, data, log, recording, learning_curve, output;
  std::vector<std::string> times, comparisons;
  std::vector<double> levels_deg{0, 0.01, 0.02, 0.05, 0.1};
  bool faults = false;
  int trials = 2000, realisations = 25;
  std::uint64_t seed = 99;
};

std::pair<std::string, double> time_from_text(const std::string& text) {
  const std::size_t equals = text.find('=');
  const double seconds = equals == std::string::npos ? NAN : number_from<double>(text.substr(equals + 1)).value_or(NAN);
  if (equals == 0 || !std::isfinite(seconds) || seconds < 0)
    throw Error(Code::setting_malformed, "--time", "'" + text + "' is not NAME=SECONDS",
                "give for example --time training=2400");
  return {text.substr(0, equals), seconds};
}

void add_recording(const StudyOptions& options, const Model& model, ModelStudy& study) {
  ReadOptions reading = options.reading.read_options();
  reading.body = options.reading.body();
  const std::vector<RecordingSource> sources = make_sources({options.recording}, reading.recording);
  if (sources.size() != 1)
    throw Error(Code::recording_ambiguous, options.recording,
                "holds " + counted(std::ssize(sources), "recording") + " by --trial " + options.reading.trial +
                    ", but a study uses one",
                "save that recording as a file of its own");
  study.recording = identify_plan(model, model_name(options.model), make_plan(sources, reading)).recordings.front();
  if (study.recording->error) throw *study.recording->error;
  const sim::Parameters of_model =
      for_body(model, model_name(options.model), reading.body).to_model(model, study.recording->estimate.parameters);
  for (std::size_t p = 0; p < of_model.size(); ++p)
    study.recording_output.push_back((of_model[p] - model.targets.mean[p]) / model.targets.stddev[p]);
}

void refuse_without_recording(const StudyOptions& options, const Command& command) {
  if (!options.recording.empty()) return;
  std::vector<std::string> of_recordings{"--mass", "--height"};
  of_recordings.insert(of_recordings.end(), std::begin(reading_options), std::end(reading_options));
  for (const std::string& name : of_recordings)
    if (command.count(name) > 0)
      throw Error(Code::setting_conflict, name, "has no effect without a recording", "use it with --recording");
}

/// Returns the training log's file: decid train writes it beside the model. Empty if there is none.
std::string log_file(const StudyOptions& options) {
  if (!options.log.empty() || options.model.empty()) return options.log;
  const std::string beside = options.model + ".log.csv";
  return std::filesystem::exists(beside) ? beside : std::string();
}

/// Returns the study with the figures of the model and of the files that the call names, before all computations.
ModelStudy begin_study(const StudyOptions& options, const Model& model, const std::string& log) {
  ModelStudy study;
  for (const std::string& text : options.times) study.seconds.push_back(time_from_text(text));
  study.model = model_name(options.model);
  study.sha256 = nn::weights_sha256(model.network);
  study.version = version;
  study.fresh_seed = options.seed;
  study.origin = model.origin;
  study.protocol = model.protocol;
  study.target_stddev = model.targets.stddev;
  study.image = model.image();
  study.network_parameters = model.network.parameter_count();
  study.architecture = model.network.architecture();
  if (!log.empty()) study.log = read_log(log);
  if (!options.learning_curve.empty()) study.learning_curve = read_learning_curve(options.learning_curve);
  for (const std::string& file : options.comparisons) {
    study.comparisons.push_back(read_comparison(file, model.protocol));
    if (study.comparisons.back().sha256 != study.sha256)
      throw Error(Code::file_differs, file, "compares another model than " + study.model,
                  "run decid compare with this --model");
  }
  if (!options.recording.empty()) add_recording(options, model, study);
  return study;
}

/// Writes the study into its folder. Returns what is printed.
std::string write_study(const StudyOptions& options, const Command& command, const ModelStudy& study,
                        const std::string& log) {
  const std::filesystem::path folder = options.output;
  const std::vector<Figure> figures = study_figures(study);
  std::vector<std::string> inputs = options.comparisons, outputs{"table.txt", "study.json", "report.html"};
  for (const std::string& input : {options.model, options.data, log, options.recording, options.learning_curve})
    inputs.push_back(input);
  for (const Figure& figure : figures) outputs.insert(outputs.end(), {figure.id + ".svg", figure.id + ".csv"});
  for (const std::string& output : outputs) refuse_same_file((folder / output).string(), inputs);
  const std::string text = study_text(study);
  // A file name need not be UTF-8; other bytes are replaced.
  Call call = record_call(command, inputs);
  call.seed = options.seed;
  Json result = study_json(study);
  add_call(result, call);
  const std::string json = print_json(result) + "\n";
  for (const Figure& figure : figures) {
    write_file(folder / (figure.id + ".svg"), figure.svg);
    write_file(folder / (figure.id + ".csv"), figure.csv);
  }
  write_file(folder / "table.txt", text);
  write_file(folder / "study.json", json);
  write_file(folder / "report.html", study_html(study, figures, call));
  return options.common.json ? json : text;
}

void run_study(const StudyOptions& options, const Command& command) {
  refuse_without_recording(options, command);
  const Model model = model_or_built_in(options.model);
  require_controller(options.controller, model.protocol, model_name(options.model));
  const std::string log = log_file(options);
  ModelStudy study = begin_study(options, model, log);
  const std::filesystem::path folder = options.output;
  make_output_folder(folder);
  { PendingFile probe(folder / "report.html"); }  // reports an unwritable place before the work

  const Announce announce = [&](const std::string& text) {
    if (!options.common.quiet) std::cerr << "study: " << text << '\n';
  };
  if (!options.data.empty()) study_dataset(model, options.data, study, announce);
  study_fresh(model, options.trials, options.levels_deg, study, announce);
  study_double(model, options.realisations, study, announce);
  if (options.faults) {
    FaultStudy found = study_faults(model, study.faults_noise_deg, options.trials, options.seed, announce);
    study.faults = std::move(found.rows);
    study.notes.insert(study.notes.end(), found.notes.begin(), found.notes.end());
  }
  announce("drawing");
  std::cout << write_study(options, command, study, log);
  announce("written to " + folder.string() + ": report.html, table.txt, study.json and the figures");
}

}  // namespace

void add_study(const Command& program) {
  auto options = std::make_shared<StudyOptions>();
  const Command command = program.add_subcommand("study", "Compare a model with the paper: table, figures, accuracy");
  command.section("Model");
  command.add_option("--model", options->model, "Use this model file; default: the built-in model");
  add_controller_of_model(command, options->controller);
  command.add_option(
      "--data", options->data,
      "Show the training and validation errors and the figures of this data set, on which the model was trained");
  command.add_option("--log", options->log, "Read this training log; default: MODEL.log.csv, if it exists");
  command.add_option("--recording", options->recording,
                     "Use this CSV, MAT, C3D or .xlsx file instead of the paper's human trial");
  add_reading_options(command, options->reading);
  add_body_options(command, options->reading);
  command.section("Trials");
  command.add_option("--trials", options->trials, "Evaluate on this many test trials").range(1, 1'000'000);
  add_seed_option(command, options->seed, "Seed the test trials; use another seed than the training's");
  command
      .add_option("--sensor-noise", options->levels_deg,
                  "Evaluate at these levels of measurement noise, standard deviations in degrees")
      .values(1, 20)
      .range(0.0, 10.0);
  command
      .add_option("--realisations", options->realisations,
                  "Simulate the double pendulum with this many realisations of its noise")
      .range(1, 10'000);
  command.add_flag(
      "--faults", options->faults,
      "Also measure recording artefacts, at 0.02 degrees of measurement noise; takes 6 minutes more for 2000 trials");
  command.add_option("--learning-curve", options->learning_curve,
                     "Plot the error over the number of training trials from this CSV file: columns trials and mse");
  command
      .add_option("--comparison", options->comparisons,
                  "Add this result of decid compare -o for the model; may be repeated")
      .repeatable();
  command.add_option("--time", options->times, "Add a line to the table of times: NAME=SECONDS; may be repeated")
      .repeatable();
  add_output_option(command, "-o,--output", options->output, Written::folder,
                    "Write report.html, table.txt, study.json and each figure as .svg and .csv to this folder")
      .required();
  command.footer(
      "Examples:\n"
      "  decid study -o study\n"
      "  decid study --model model.safetensors --data data.npz --recording trial.csv -o study\n"
      "  decid study --faults --trials 500 -o study");
  run_with(command, options, true, run_study);
}

}  // namespace decid::tools
