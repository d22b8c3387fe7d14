// decid fit: recordings or a published frequency response in, the posterior of their controllers out.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <iostream>
#include <memory>
#include <numeric>
#include <optional>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "identify/fit_recordings.hpp"
#include "identify/network/for_body.hpp"
#include "sim/protocol/protocol_json.hpp"
#include "sim/segments.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/commands/fit_frf.hpp"
#include "tools/decid/fit_journal.hpp"
#include "tools/decid/group_file.hpp"
#include "tools/decid/interrupt.hpp"
#include "tools/decid/progress.hpp"
#include "tools/decid/ranks.hpp"
#include "tools/decid/recording_flags.hpp"
#include "tools/decid/results/fit_results.hpp"
#include "tools/decid/results/group_results.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/decid/results/results_table.hpp"
#include "tools/report/fit_page.hpp"
#include "tools/report/other_answer.hpp"

namespace decid::tools {
namespace {

struct FitOptions {
  CommonOptions common;
  RecordingFlags recordings;
  std::string model, protocol, output, draws, frf, report, table, group;
  bool resume = false;
  std::optional<double> amplitude_deg, prior_error, prior_gain;
  std::vector<std::string> ranges, priors;  ///< of parameters: NAME=LOW,HIGH and NAME=MEAN,SD
  FitRequest request;
};

/// Options of recordings alone besides how they are read, and those of a frequency response alone.
constexpr const char* of_recordings[] = {"recordings", "--model", "--prior-start", "--prior-noise",  "--max-draws",
                                         "--report",   "--table", "--group",       "--moved-before", "--resume",
                                         "--range",    "--prior", "--recursive"};
constexpr const char* of_tables[] = {"--amplitude", "--prior-error"};

/// Throws Error for options that do not go with what is to be fitted.
void check_kind(const FitOptions& options, const Command& command) {
  const bool is_table = !options.frf.empty();
  if (!is_table && options.recordings.files.empty())
    throw Error("fit", "neither a recording nor a frequency response is named",
                "name CSV, MAT, C3D or .xlsx files, or a table with --frf");
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

/// "NAME=NUMBER,NUMBER" as an option says it of a parameter.
struct NamedPair {
  std::string name;
  double first, second;
};

NamedPair pair_of(const std::string& text, const char* option, const char* form, const sim::ParameterTable& table) {
  const auto fail = [&](const std::string& problem) { throw Error(option, problem, std::string("give ") + form); };
  const std::size_t equals = text.find('='), comma = text.find(',', equals == std::string::npos ? 0 : equals);
  if (equals == std::string::npos || comma == std::string::npos) fail("'" + text + "' is not " + form);
  const auto number = [&](std::size_t begin, std::size_t end) {
    double value = 0.0;
    const auto [last, error] = std::from_chars(text.data() + begin, text.data() + end, value);
    if (error != std::errc() || last != text.data() + end || !std::isfinite(value))
      fail("'" + text.substr(begin, end - begin) + "' is not a number");
    return value;
  };
  NamedPair pair{text.substr(0, equals), number(equals + 1, comma), number(comma + 1, text.size())};
  const std::vector<std::string> names = table.names();
  if (std::ranges::find(names, pair.name) == names.end()) {
    std::string all;
    for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
    throw Error(option, "'" + pair.name + "' is not a parameter", "name one of " + all);
  }
  return pair;
}

/// What --range and --prior say of the parameters. Throws Error naming the option.
std::vector<posterior::ParameterPrior> parameter_priors(const FitOptions& options, const sim::ParameterTable& table) {
  std::vector<posterior::ParameterPrior> all;
  const auto prior_of = [&](const std::string& name) -> posterior::ParameterPrior& {
    const auto found = std::ranges::find(all, name, &posterior::ParameterPrior::name);
    return found != all.end() ? *found : all.emplace_back(posterior::ParameterPrior{name, {}, {}});
  };
  const auto twice = [](const char* option, const std::string& name) {
    throw Error(option, "is given twice for " + name, "give it once");
  };
  for (const std::string& text : options.ranges) {
    const NamedPair pair = pair_of(text, "--range", "NAME=LOW,HIGH", table);
    posterior::ParameterPrior& prior = prior_of(pair.name);
    if (prior.range) twice("--range", pair.name);
    prior.range = {pair.first, pair.second};
  }
  for (const std::string& text : options.priors) {
    const NamedPair pair = pair_of(text, "--prior", "NAME=MEAN,SD", table);
    posterior::ParameterPrior& prior = prior_of(pair.name);
    if (prior.normal) twice("--prior", pair.name);
    prior.normal = {pair.first, pair.second};
  }
  posterior::Priors priors;
  priors.parameters = all;
  try {
    static_cast<void>(posterior::ranges_of(priors, table));
  } catch (const Error& error) {
    throw Error(error.where().starts_with("range") ? "--range" : "--prior", error.where() + " " + error.problem(),
                error.remedy());
  }
  return all;
}

std::vector<std::string> outputs_of(const FitOptions& options) {
  return {options.output, options.draws, options.report, options.table};
}

/// Throws Error if an output would replace an input or another output, or cannot be written.
void check_outputs(const FitOptions& options, std::vector<std::string> inputs) {
  for (const std::string& path : outputs_of(options)) {
    refuse_same_file(path, inputs);
    inputs.push_back(path);
  }
  for (const std::string& path : outputs_of(options))
    if (!path.empty() && is_root()) PendingFile probe(path);  // reports an unwritable place before the work
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

void run_table(const FitOptions& options, const Command& command) {
  if (!is_root()) return;  // one answer, on one rank
  std::vector<std::string> inputs{options.frf};
  const sim::Protocol named =
      read_protocol(options.protocol.empty() ? "default" : options.protocol, options.common.quiet, &inputs);
  check_outputs(options, inputs);
  FrfFit asked{.table = options.frf,
               .output = options.output,
               .draws = options.draws,
               .protocol = protocol_of(options, named),
               .truth = {},
               .priors = {.gain = options.prior_gain.value_or(frf::Priors{}.gain), .error = options.prior_error},
               .particles = {.seed = options.request.settings.seed},
               .json = options.common.json,
               .options = command.given(beside_answers),
               .body_assumed = !options.recordings.body() && named.experiment.body == sim::Body{}};
  asked.truth = options.recordings.known(asked.protocol.parameters());
  run_frf_fit(asked);
}

/// The recordings of a call, in their order, and what is known of them.
struct Fits {
  Identifications common;     ///< what they have in common; of a recording that is begun its name and error
  std::vector<Json> results;  ///< null: not begun

  bool all_begun() const {
    return std::ranges::none_of(results, [](const Json& result) { return result.is_null(); });
  }
};

/// Beside the output of several recordings; none where that is no file that stays.
std::optional<FitJournal> journal_of(const FitOptions& options, const Json& settings) {
  if (options.resume && options.output.empty())
    throw Error("--resume", "needs --output", "name the file to go on with");
  const std::filesystem::path output(options.output);
  const bool is_file = !std::filesystem::exists(output) || std::filesystem::is_regular_file(output);
  if (options.output.empty() || options.recordings.files.size() < 2 || !is_file) return std::nullopt;
  return std::make_optional<FitJournal>(options.output + ".journal", settings, options.resume);
}

/// Drops what no output needs.
Json kept(Json result, const FitOptions& options) {
  if (options.report.empty()) result.erase("page");
  if (options.draws.empty()) result.erase("draws");
  return result;
}

/// Of the files, those that no journal has; what it has is in fits.
std::vector<std::size_t> files_left(const FitOptions& options, FitJournal* journal, std::vector<std::string>& keys,
                                    Fits& fits) {
  const std::vector<std::string>& files = options.recordings.files;
  fits.results.resize(files.size());
  keys.resize(files.size());
  std::vector<std::size_t> left;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (journal != nullptr) keys[i] = FitJournal::key(options.recordings.sources[i]);
    const Json* const done = journal != nullptr ? journal->find(keys[i]) : nullptr;
    if (done != nullptr) fits.results[i] = kept(*done, options);
    if (done == nullptr) left.push_back(i);
  }
  return left;
}

/// Names of the files whose work was begun, with their errors.
std::vector<Identification> begun_of(const Fits& fits, std::vector<Identification> all) {
  std::vector<Identification> begun;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (!fits.results[i].is_null()) begun.push_back(std::move(all[i]));
  return begun;
}

std::vector<Identification> named(const std::vector<std::string>& files) {
  std::vector<Identification> all(files.size());
  for (std::size_t i = 0; i < files.size(); ++i) all[i].file = files[i];
  return all;
}

/// Some recordings at a time to each rank; what the outputs hold of them comes back.
Fits fit_together(const FitOptions& options, const Model& model, const sim::Protocol& protocol,
                  const ReadOptions& reading, FitJournal* journal) {
  const std::vector<std::string>& files = options.recordings.files;
  require_same("the list of recordings", listed(files), "give all hosts the same files");
  Fits fits;
  std::vector<std::string> keys;
  std::vector<std::size_t> left = files_left(options, journal, keys, fits);  // what rank 0 finds counts
  left = parse_json(broadcast_text(*ranks(), Json(left).dump()), "fit").get<std::vector<std::size_t>>();
  std::vector<Identification> begun = named(files);
  const auto fit_some = [&](std::size_t first, std::size_t last) {
    std::vector<RecordingSource> sources;
    for (std::size_t i = first; i < last; ++i) sources.push_back(options.recordings.sources[left[i]]);
    std::vector<std::string> results(sources.size());
    fit_recordings(
        &model, protocol, sources, reading, options.request,
        [](std::size_t, const posterior::Progress&) { return !interrupted(); },
        [&](FittedRecordings& all, std::size_t i) {
          Json result{{"result", fit_result(all, i, options.request.priors)}};
          if (const auto& error = all.identified.recordings[i].error)
            result["error"] = {error->where(), error->problem(), error->remedy()};
          Json::to_cbor(result, results[i]);
          all.fits[i] = {};
        });
    return interrupted() ? std::vector<std::string>() : results;
  };
  ProgressBar bar("fit", "recordings", static_cast<long long>(files.size()), options.common.quiet);
  auto done = static_cast<long long>(files.size() - left.size());
  bar.go_on_from(done);
  share_out(
      left.size(), static_cast<std::size_t>(thread_count()), fit_some,
      [&](std::size_t number, const std::string& bytes) {
        const std::size_t i = left[number];
        Json whole = Json::from_cbor(bytes);
        if (whole.contains("error")) begun[i].error = Error(whole["error"][0], whole["error"][1], whole["error"][2]);
        if (journal != nullptr && !begun[i].error) journal->append(keys[i], whole["result"]);
        fits.results[i] = kept(std::move(whole["result"]), options);
        bar.update(++done);
      },
      interrupted);
  fits.common =
      std::move(fit_recordings(&model, protocol, std::vector<RecordingSource>(), reading, options.request).identified);
  fits.common.recordings = begun_of(fits, std::move(begun));
  return fits;
}

Fits fit_alone(const FitOptions& options, const Model& model, const sim::Protocol& protocol, const ReadOptions& reading,
               FitJournal* journal) {
  const std::vector<std::string>& files = options.recordings.files;
  Fits fits;
  std::vector<std::string> keys;
  const std::vector<std::size_t> left = files_left(options, journal, keys, fits);
  std::vector<Identification> begun = named(files);
  std::vector<RecordingSource> sources;
  for (const std::size_t i : left) sources.push_back(options.recordings.sources[i]);

  constexpr int parts = 100;  // of a recording, for the bar
  const bool several = files.size() > 1;
  ProgressBar bar("fit", several ? "recordings" : "%", static_cast<long long>(several ? files.size() : parts),
                  options.common.quiet, several ? parts : 1);
  const auto before = static_cast<double>(files.size() - left.size());
  bar.go_on_from(static_cast<long long>(parts * before));
  std::vector<double> done(left.size());  // of each
  FittedRecordings fitted = fit_recordings(
      &model, protocol, sources, reading, options.request,
      [&](std::size_t recording, const posterior::Progress& progress) {
        done[recording] = progress.done;
        bar.update(static_cast<long long>(parts * std::accumulate(done.begin(), done.end(), before)),
                   progress.rhat > 0.0 ? format("%s, R-hat %.2f", progress.stage, progress.rhat) : progress.stage);
        return !interrupted();
      },
      [&](FittedRecordings& all, std::size_t recording) {
        const std::size_t i = left[recording];
        Json result = fit_result(all, recording, options.request.priors);
        begun[i].error = all.identified.recordings[recording].error;
        if (journal != nullptr && !begun[i].error && !all.fits[recording].stopped) journal->append(keys[i], result);
        fits.results[i] = kept(std::move(result), options);
        all.fits[recording] = {};
        done[recording] = 1.0;
      });
  fits.common = std::move(fitted.identified);
  fits.common.recordings = begun_of(fits, std::move(begun));
  return fits;
}

void write_results(const FitOptions& options, const MadeWith& with, const Fits& fits, const GroupTable& groups) {
  Json recordings = Json::array();
  std::vector<Json> pages;
  std::vector<std::string> failed;
  GroupTable begun{groups.person_column, {}, groups.unused};
  std::string text;
  for (std::size_t i = 0; i < fits.results.size(); ++i) {
    const Json& result = fits.results[i];
    if (result.is_null()) continue;
    recordings.push_back(result.at("recording"));
    text += result.at("text").get<std::string>();
    if (result.contains("page")) pages.push_back(result.at("page"));
    if (recordings.back().contains("error")) failed.push_back(recordings.back().at("error"));
    if (!groups.members.empty()) begun.members.push_back(groups.members[i]);
  }
  const sim::ParameterTable table = posterior::ranges_of(options.request.priors, fits.common.protocol.ranges());
  const Json compared = options.group.empty() ? Json(nullptr) : groups_json(recordings, begun, table);
  const std::string json = recordings_json(with, fits.common, recordings, compared);
  if (!options.draws.empty()) write_draws(options.draws, fits.results);
  if (!options.report.empty())
    write_file(options.report, fit_report_html(version, options.request, std::move(pages), failed,
                                               page_groups(compared, recordings), with.other_answer));
  if (!options.table.empty()) write_file(options.table, results_table(recordings, table));
  if (!options.output.empty()) write_file(options.output, json);
  std::cout << (options.common.json ? json : text + groups_text(compared) + body_text(fits.common));
}

void run_fit(FitOptions options, const Command& command) {
  RecordingFlags& recordings = options.recordings;
  ReadOptions reading = recordings.read_options();
  std::vector<std::string> inputs = outputs_of(options);
  inputs.insert(inputs.end(), {options.model, options.protocol, options.group});
  recordings.find_sources(inputs, options.common.quiet);
  inputs = recordings.distinct_files();
  inputs.insert(inputs.end(), {options.model, options.group});
  std::optional<sim::Protocol> given;
  if (!options.protocol.empty()) given = read_protocol(options.protocol, options.common.quiet, &inputs);
  check_outputs(options, inputs);
  const GroupTable groups = groups_of(options.group, recordings, options.common.quiet);
  const Model model = model_or_built_in(options.model);
  const sim::Protocol protocol = protocol_of(options, given.value_or(model.protocol));
  options.request.priors.parameters = parameter_priors(options, protocol.ranges());
  reading.truth = recordings.known(protocol.parameters());
  reading.body = recordings.body();
  // A protocol of one's own may describe it.
  if (!reading.body && given && given->experiment.body != sim::Body{}) reading.body = given->experiment.body;

  const Json settings{{"version", version},
                      {"protocol", parse_json(sim::to_json(protocol), "protocol")},
                      {"model", nn::weights_sha256(model.network)},
                      {"options", command.given(beside_answers)}};
  std::optional<FitJournal> journal = is_root() ? journal_of(options, settings) : std::nullopt;
  catch_interrupt();
  const auto fit_files = ranks() == nullptr ? fit_alone : fit_together;
  const Fits fits = fit_files(options, model, protocol, reading, journal ? &*journal : nullptr);
  if (!is_root()) return;
  refuse_alone(fits.common.recordings);
  write_results(options,
                {model_name(options.model), nn::weights_sha256(model.network), command.given(beside_answers),
                 knows_experiment(model, fits.common.protocol.experiment) ? std::optional(beside_fit) : std::nullopt},
                fits, groups);
  const bool failed =
      std::ranges::any_of(fits.common.recordings, [](const Identification& id) { return id.error.has_value(); });
  if (journal && !failed && fits.all_begun() && !interrupted()) journal->remove();
  if (interrupted())
    throw std::runtime_error(format("stopped at recording %zu of %zu; what was drawn until then was written%s",
                                    fits.common.recordings.size(), fits.results.size(),
                                    journal ? "; --resume goes on" : ""));
  if (journal && failed && !options.common.quiet) std::cerr << "decid: mend them, and --resume fits these alone\n";
  tell_errors("fit", fits.common.recordings);
}

}  // namespace

void add_fit(const Command& program) {
  auto options = std::make_shared<FitOptions>();
  const Command command = program.add_subcommand(
      "fit",
      "Sample the posterior of balance-control parameters from recordings; slower and more accurate than identify");
  add_recording_flags(command, options->recordings);
  add_truth_option(command, options->recordings);
  command.section("Input");
  command.add_option("--frf", options->frf,
                     "Fit this table of a frequency response instead of recordings: columns frequency_hz, gain, "
                     "phase_deg and, if known, sd, ci95, radius95, or coherence and cycles");
  command
      .add_option("--amplitude", options->amplitude_deg,
                  "Use this peak-to-peak tilt in degrees for --frf; default: the protocol's")
      .range(1e-3, 20.0);
  add_body_options(command, options->recordings);
  command.section("Model");
  command.add_option("--protocol", options->protocol,
                     "Use this protocol: default, short, or a JSON file; default: the model's");
  command.add_option(
      "--model", options->model,
      "Use this model file for the protocol, and for the estimate where chains disagree; default: the built-in model");
  command.section("Advanced");
  command
      .add_option("--prior-start", options->request.priors.start_s,
                  "Allow the recording to start up to this many seconds before or after the protocol; 0: it starts "
                  "with it; a tilt column overrides this")
      .show_default()
      .range(0.0, 0.5);
  command
      .add_option(
          "--prior-gain", options->prior_gain,
          format("Expect the scale of the sway sensor within this standard deviation of its logarithm; 0: exact; "
                 "default: %g. With --frf, expect the gains within 1 +- this; default: %g",
                 posterior::Priors{}.gain, frf::Priors{}.gain))
      .range(0.0, 0.5);
  command
      .add_option("--prior-noise", options->request.priors.sensor_noise_deg,
                  "Expect this measurement noise in degrees, within a factor of 20")
      .show_default()
      .range(1e-6, 10.0);
  command
      .add_option("--range", options->ranges,
                  "Limit a parameter to LOW to HIGH in its JSON unit, for example delay=0.05,0.2; may be repeated")
      .repeatable()
      .shown_as("NAME=LOW,HIGH");
  command
      .add_option("--prior", options->priors,
                  "Use a normal prior with this mean and standard deviation for a parameter, for example "
                  "delay=0.12,0.02; default: uniform in its range; may be repeated")
      .repeatable()
      .shown_as("NAME=MEAN,SD");
  command.add_flag("--moved-before", options->request.priors.moved_before,
                   "Assume that the platform played the end of a cycle before the recording; default: it rested");
  command
      .add_option("--prior-error", options->prior_error,
                  "Allow errors of an --frf table beyond its confidence, as a fraction of the response, within a "
                  "factor of 3; default: 0.01, or 0.05 for a table without confidence")
      .range(0.0, 1.0);
  command
      .add_option("--max-draws,--most-draws", options->request.settings.max_draws,
                  "Take at most this many draws per chain; fewer where they suffice")
      .show_default()
      .range(8, 1'000'000);
  add_seed_option(command, options->request.settings.seed, "Seed the chains");
  add_output_option(command, "-o,--output", options->output, Written::json, "Write the results to this JSON file");
  add_output_option(command, "--draws", options->draws, Written::npz, "Write all draws to this NumPy file (.npz)");
  add_output_option(command, "--report", options->report, Written::html,
                    "Write a report to this HTML page, which opens offline");
  add_table_option(command, options->table);
  add_group_option(command, options->group);
  command.section("Output");
  command.add_flag("--resume", options->resume,
                   "Continue a stopped call: skip the recordings that its journal OUTPUT.journal holds");
  add_common_options(command, options->common, true);
  command.footer(
      "Examples:\n"
      "  decid fit recording.csv --mass 70 --height 1.75 -o result.json --report report.html\n"
      "  decid fit subjects -o results.json --table results.csv --resume\n"
      "  decid fit recording.csv --range delay=0.05,0.2 --prior Kp=900,100 --draws draws.npz\n"
      "  decid fit --frf response.csv --amplitude 1 --mass 70 --height 1.75 --report response.html");
  command.callback([options, command] {
    check_kind(*options, command);
    if (options->prior_gain) options->request.priors.gain = *options->prior_gain;
    options->request.settings.min_draws =
        std::min(options->request.settings.min_draws, options->request.settings.max_draws);
    apply(options->common);
    if (options->frf.empty()) return run_fit(*options, command);
    run_table(*options, command);
  });
}

}  // namespace decid::tools
