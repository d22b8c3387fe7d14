// decid fit: recordings or a published frequency response in, the posterior of their controllers out.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <numeric>
#include <optional>
#include <sstream>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/files/sha256.hpp"
#include "base/number.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "identify/fit_recordings.hpp"
#include "identify/network/for_body.hpp"
#include "identify/result_archive.hpp"
#include "identify/sheet/study_results.hpp"
#include "sim/protocol/protocol_object.hpp"
#include "sim/segments.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/commands/fit_all.hpp"
#include "tools/decid/commands/fit_frf.hpp"
#include "tools/decid/commands/fit_journal.hpp"
#include "tools/decid/group_file.hpp"
#include "tools/decid/interrupt.hpp"
#include "tools/decid/progress.hpp"
#include "tools/decid/ranks.hpp"
#include "tools/decid/recording_flags.hpp"
#include "tools/decid/results/outputs.hpp"
#include "tools/decid/results/results.hpp"

namespace decid::tools {
namespace {

struct FitOptions {
  CommonOptions common;
  RecordingFlags recordings;
  Outputs outputs;
  std::string model, protocol, frf, group;
  std::string joint, free, conditions;  ///< columns of the sheet; free: NAME,..:COLUMN
  bool resume = false;
  std::optional<double> amplitude_deg, prior_error, prior_gain;
  std::vector<std::string> ranges, priors, fixed;  ///< of parameters: NAME=LOW,HIGH, NAME=MEAN,SD and NAME=VALUE
  std::string controllers;                         ///< names, separated by commas
  std::string objective = "posterior";
  FitRequest request;
};

/// Options that apply only to recordings, except the file-reading options, and options that apply only to a frequency
/// response.
constexpr const char* of_recordings[] = {"recordings",  "--model",     "--prior-start", "--prior-noise",
                                         "--max-draws", "--table",     "--group",       "--moved-before",
                                         "--resume",    "--recursive", "--study",       "--long",
                                         "--excel",     "--figures",   "--joint",       "--free"};
constexpr const char* of_tables[] = {"--amplitude", "--prior-error", "--objective"};

/// Throws Error for options that do not apply to the input.
void check_kind(const FitOptions& options, const Command& command) {
  const bool is_table = !options.frf.empty();
  if (!is_table && options.recordings.files.empty() && options.recordings.study.empty())
    throw Error(Code::setting_missing, "fit", "neither a recording nor a frequency response is named",
                "name CSV, MAT, C3D or .xlsx files, a sheet with --study, or a table with --frf");
  const auto refuse = [&](const char* option) {
    if (command.count(option) == 0) return;
    if (is_table && std::string(option) == "recordings")
      throw Error(Code::setting_conflict, "--frf", "does not go with recordings", "fit them in a call of their own");
    throw Error(Code::setting_conflict, option, is_table ? "is not for --frf" : "is for --frf alone", "leave it out");
  };
  if (is_table) std::ranges::for_each(of_recordings, refuse);
  if (is_table) std::ranges::for_each(reading_options, refuse);
  if (!is_table) std::ranges::for_each(of_tables, refuse);
}

/// Throws Error for a name that is not in the table.
void require_parameter(const std::string& name, const char* option, const sim::ParameterTable& table) {
  const std::vector<std::string> names = table.names();
  if (std::ranges::find(names, name) != names.end()) return;
  std::string all;
  for (const std::string& one : names) all += (all.empty() ? "" : ", ") + one;
  throw Error(Code::setting_unknown, option, "'" + name + "' is not a parameter", "name one of " + all);
}

/// Reads "NAME=NUMBER" or "NAME=NUMBER,NUMBER", an option's text for a parameter of the table.
struct NamedNumbers {
  NamedNumbers(const std::string& text, std::size_t count, const char* option, const char* form,
               const sim::ParameterTable& table) {
    const auto fail = [&](const std::string& problem) {
      throw Error(Code::setting_malformed, option, problem, std::string("give ") + form);
    };
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) fail("'" + text + "' is not " + form);
    name = text.substr(0, equals);
    for (std::size_t begin = equals + 1; begin <= text.size();) {
      const std::size_t end = std::min(text.find(',', begin), text.size());
      const auto [last, error] = std::from_chars(text.data() + begin, text.data() + end, numbers.emplace_back());
      if (error != std::errc() || last != text.data() + end || !std::isfinite(numbers.back()))
        fail("'" + text.substr(begin, end - begin) + "' is not a number");
      begin = end + 1;
    }
    if (numbers.size() != count) fail("'" + text + "' is not " + form);
    require_parameter(name, option, table);
  }
  std::string name;
  std::vector<double> numbers;
};

/// Returns the priors that --range, --prior and --fix give for the parameters. Throws Error naming the option.
std::vector<posterior::ParameterPrior> parameter_priors(const FitOptions& options, const sim::ParameterTable& table) {
  using posterior::ParameterPrior;
  std::vector<ParameterPrior> all;
  const auto prior_of = [&](const std::string& name) -> ParameterPrior& {
    const auto found = std::ranges::find(all, name, &ParameterPrior::name);
    return found != all.end() ? *found : all.emplace_back(ParameterPrior{.name = name});
  };
  const auto read = [&](const std::vector<std::string>& texts, std::size_t count, const char* option, const char* form,
                        auto member, const auto& value_of) {
    for (const std::string& text : texts) {
      const NamedNumbers given(text, count, option, form, table);
      auto& value = prior_of(given.name).*member;
      if (value) throw Error(Code::setting_conflict, option, "is given twice for " + given.name, "give it once");
      value = value_of(given.numbers);
    }
  };
  using Numbers = std::vector<double>;
  read(options.ranges, 2, "--range", "NAME=LOW,HIGH", &ParameterPrior::range, [](const Numbers& numbers) {
    return ParameterPrior::Range{numbers[0], numbers[1]};
  });
  read(options.priors, 2, "--prior", "NAME=MEAN,SD", &ParameterPrior::normal, [](const Numbers& numbers) {
    return ParameterPrior::Normal{numbers[0], numbers[1]};
  });
  read(options.fixed, 1, "--fix", "NAME=VALUE", &ParameterPrior::fixed,
       [](const Numbers& numbers) { return numbers[0]; });
  posterior::Priors priors;
  priors.parameters = all;
  try {
    static_cast<void>(posterior::ranges_of(priors, table));
  } catch (const Error& error) {
    const bool fixes = std::ranges::any_of(
        all, [&](const ParameterPrior& prior) { return prior.fixed && error.where().ends_with(" " + prior.name); });
    throw Error(error.code(),
                error.where().starts_with("range") ? "--range"
                : fixes                            ? "--fix"
                                                   : "--prior",
                error.where() + " " + error.problem(), error.remedy());
  }
  return all;
}

/// Returns the controllers that --controller names, in its order. Throws Error if the protocol names another one.
std::vector<const sim::BodyModel*> controllers_of(const std::string& names, const sim::Protocol& protocol) {
  std::vector<const sim::BodyModel*> all;
  std::istringstream stream(names);
  for (std::string name; std::getline(stream, name, ',');) {
    const sim::BodyModel& model = sim::body_model_of(name, "--controller");
    if (std::ranges::find(all, &model) != all.end())
      throw Error(Code::setting_conflict, "--controller", "names " + name + " twice", "name each once");
    all.push_back(&model);
  }
  const sim::BodyModel* own = protocol.experiment.body_model;
  if (all.empty()) return {own};
  if (own != &sim::single_pendulum() && std::ranges::find(all, own) == all.end())
    throw Error(Code::setting_conflict, "--controller",
                "does not name " + own->name + ", the controller of protocol '" + protocol.name + "'",
                "leave it out, or use a protocol without a controller");
  return all;
}

/// Returns the chosen protocol, with the subject's body if the options describe one.
sim::Protocol protocol_of(const FitOptions& options, sim::Protocol protocol) {
  if (const std::optional<sim::Body> body = options.recordings.body()) protocol.experiment.body = *body;
  if (options.amplitude_deg) {
    if (!std::holds_alternative<sim::Sequence>(protocol.experiment.stimulus))
      throw Error(Code::setting_conflict, "--amplitude",
                  "protocol '" + protocol.name + "' plays no ternary sequence, the tilt that it scales",
                  "leave it out, and give the amplitudes in the protocol's file");
    protocol.sequence().amplitude_deg = *options.amplitude_deg;
  }
  protocol.validate();
  return protocol;
}

/// Removes the options for parameters that this controller does not have and another one of the call has.
FitOptions for_controller(FitOptions options, const sim::BodyModel& controller,
                          const std::vector<const sim::BodyModel*>& all) {
  const auto has = [](const sim::BodyModel& model, const std::string& text) {
    const std::vector<std::string> names = model.parameters.names();
    return std::ranges::find(names, text.substr(0, text.find('='))) != names.end();
  };
  for (auto* texts : {&options.ranges, &options.priors, &options.fixed})
    std::erase_if(*texts, [&](const std::string& text) {
      return !has(controller, text) &&
             std::ranges::any_of(all, [&](const sim::BodyModel* other) { return has(*other, text); });
    });
  return options;
}

void run_table(const FitOptions& options, const Command& command) {
  if (!is_root()) return;  // one answer, on one rank
  std::vector<std::string> inputs{options.frf};
  const sim::Protocol named =
      read_protocol(options.protocol.empty() ? "default" : options.protocol, options.common.quiet, &inputs);
  options.outputs.check(inputs);
  if (options.outputs.draws.ends_with(".csv"))
    throw Error(Code::setting_conflict, "--draws", "writes .npz for --frf", "give a name that ends in .npz");
  FrfFit asked{.table = options.frf,
               .output = options.outputs.json,
               .draws = options.outputs.draws,
               .page = options.outputs.page,
               .controllers = {},
               .truth = {},
               .particles = {.seed = options.request.settings.seed},
               .log_ratio = options.objective == "log-ratio",
               .json = options.common.json,
               .options = command.given(beside_answers),
               .body_assumed = !options.recordings.body() && named.experiment.body == sim::Body{}};
  sim::Protocol protocol = protocol_of(options, named);
  const std::vector<const sim::BodyModel*> controllers = controllers_of(options.controllers, protocol);
  for (const sim::BodyModel* controller : controllers) {
    protocol.experiment.body_model = controller;
    frf::Priors priors{
        .gain = options.prior_gain.value_or(frf::Priors{}.gain),
        .error = options.prior_error,
        .parameters = parameter_priors(for_controller(options, *controller, controllers), protocol.ranges())};
    asked.controllers.push_back({protocol, std::move(priors)});
  }
  if (asked.log_ratio && !options.priors.empty())
    throw Error(Code::setting_conflict, "--prior", "is not for --objective log-ratio, which has only ranges",
                "give --range or --fix");
  const sim::ParameterTable& parameters = asked.controllers.front().protocol.parameters();
  if (asked.controllers.size() == 1) asked.truth = options.recordings.known(parameters);
  if (asked.controllers.size() > 1 && command.count("--truth") > 0)
    throw Error(Code::setting_conflict, "--truth", "does not go with several controllers",
                "name one with --controller");
  run_frf_fit(asked);
}

/// Opens the journal beside the output of several recordings. Returns nothing if there is no output or it is not a
/// regular file.
std::optional<FitJournal> journal_of(const FitOptions& options, const std::string& settings) {
  const std::string& output = options.outputs.json;
  if (options.resume && output.empty())
    throw Error(Code::setting_missing, "--resume", "needs --output", "name the file to go on with");
  const bool is_file = !std::filesystem::exists(output) || std::filesystem::is_regular_file(output);
  if (output.empty() || options.recordings.files.size() < 2 || !is_file) return std::nullopt;
  return std::make_optional<FitJournal>(output + ".journal", settings, options.resume);
}
