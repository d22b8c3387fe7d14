// decid design: what recordings with different protocols would tell, before a study.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <iterator>
#include <map>
#include <memory>

#include "base/error.hpp"
#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "posterior/planning/expected_posterior.hpp"
#include "posterior/planning/variations.hpp"
#include "sim/protocol/protocol_json.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/named_values.hpp"
#include "tools/decid/prior_texts.hpp"
#include "tools/decid/progress.hpp"
#include "tools/decid/recording_flags.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/report/json/recording_json.hpp"

namespace decid::tools {
namespace {

/// A larger tilt, from peak to peak, is beyond the usual experiments with standing people.
constexpr double usual_tilt_deg = 8.0;

struct DesignOptions {
  CommonOptions common;
  BodyFlags body;
  std::vector<std::string> protocols, at, fixed;
  std::string controller;
  std::vector<double> amplitudes_deg, cycles;
  posterior::PlannedRecordings planned;
  posterior::Priors priors;
};

/// A protocol of the table.
struct Planned {
  std::string option;  ///< as --protocol names it
  std::string name;
  sim::Protocol protocol;
  double peak_to_peak_deg = 0.0;
  posterior::ExpectedPosterior found = {};

  bool is_large() const { return peak_to_peak_deg > usual_tilt_deg * (1.0 + 1e-9); }
};

std::string shown(double number) {
  return format("%.4g", number);
}

/// Throws Error if an option has one value twice, which would give two equal rows.
void refuse_repeated(const char* option, std::vector<double> values) {
  std::ranges::sort(values);
  const auto found = std::ranges::adjacent_find(values);
  if (found != values.end())
    throw Error(Code::setting_conflict, option, "gives " + shown(*found) + " twice", "give it once");
}

/// Returns the protocols, each with all combinations of amplitudes and cycles. files: receives the names of the files
/// that were read.
std::vector<Planned> planned_protocols(const DesignOptions& options, std::vector<std::string>& files) {
  std::vector<Planned> all;
  const std::vector<std::string> names =
      options.protocols.empty() ? std::vector<std::string>{"default", "short"} : options.protocols;
  refuse_repeated("--amplitude", options.amplitudes_deg);
  refuse_repeated("--cycles", options.cycles);
  std::map<std::string, std::string> given;  // contents, and their names on the command line
  for (const std::string& name : names) {
    sim::Protocol protocol = read_protocol(name, options.common.quiet, &files, options.controller);
    options.body.refuse_instead_of(protocol);
    if (const std::optional<sim::Body> body = options.body.body()) protocol.experiment.body = *body;
    protocol.validate();
    const auto [same, is_new] = given.try_emplace(sim::to_json(protocol), name);
    if (!is_new)
      throw Error(Code::setting_conflict, "--protocol",
                  same->second == name ? "gives " + name + " twice"
                                       : "gives " + same->second + " and " + name + ", which are one protocol",
                  "give it once");
    std::vector<Planned> variants{{name, protocol.name, protocol}};
    const auto vary = [&](const std::vector<double>& values, const char* one_of, const char* more_of, auto make) {
      if (values.empty()) return;
      std::vector<Planned> next;
      for (const Planned& one : variants)
        for (const double value : values)
          next.push_back(
              {name, one.name + ", " + shown(value) + (value == 1.0 ? one_of : more_of), make(one.protocol, value)});
      variants = std::move(next);
    };
    vary(options.amplitudes_deg, " deg", " deg", posterior::with_peak_to_peak);
    vary(options.cycles, " cycle", " cycles", [](const sim::Protocol& one, double cycles) {
      if (cycles != std::floor(cycles))
        throw Error(Code::setting_malformed, "--cycles", shown(cycles) + " is not a whole number",
                    "give whole cycles, such as 1 2 4");
      return posterior::with_cycles(one, static_cast<int>(cycles));
    });
    std::ranges::move(variants, std::back_inserter(all));
  }
  for (Planned& one : all)
    one.peak_to_peak_deg = sim::make_stimulus(one.protocol.experiment).peak_to_peak_rad() / sim::rad_per_deg;
  return all;
}

void require_same_controller(const std::vector<Planned>& all) {
  for (const Planned& one : all)
    if (one.protocol.experiment.body_model != all.front().protocol.experiment.body_model)
      throw Error(Code::setting_conflict, "--protocol",
                  "'" + one.option + "' has another controller than '" + all.front().option + "'",
                  "give protocols of one controller, or --controller");
}

/// Throws Error for values over m g h if the protocols have several bodies: a parameter has one value in a call.
void refuse_other_bodies(const DesignOptions& options, const std::vector<Planned>& all) {
  const auto over_mgh = [](const std::string& text) { return NamedText(text).name.over_mgh; };
  if (std::ranges::none_of(options.at, over_mgh) && std::ranges::none_of(options.fixed, over_mgh)) return;
  for (const Planned& one : all)
    if (one.protocol.experiment.body.mgh() != all.front().protocol.experiment.body.mgh())
      throw Error(Code::setting_conflict, "--protocol",
                  "'" + one.option + "' has another body than '" + all.front().option + "'",
                  "give protocols of one body, --mass and --height, or values in N m/rad");
}

Json design_json(const DesignOptions& options, const std::vector<Planned>& all, const sim::ParameterTable& table) {
  Json list = Json::array(), parameters = Json::array();
  for (std::size_t p = 0; p < table.size(); ++p)
    parameters.push_back({{"name", table[p].name},
                          {"unit", table[p].unit},
                          {"at", all.front().found.at ? Json((*all.front().found.at)[p]) : Json(nullptr)},
                          {"prior_sd", all.front().found.prior_sd[p]}});
  for (const Planned& one : all) {
    Json of_parameters = Json::array();
    for (std::size_t p = 0; p < table.size(); ++p)
      of_parameters.push_back(
          {{"name", table[p].name}, {"sd", one.found.sd[p]}, {"relative_variance", one.found.relative_variance[p]}});
    list.push_back({{"name", one.name},
                    {"duration_s", one.protocol.duration_s()},
                    {"peak_to_peak_deg", one.peak_to_peak_deg},
                    {"large_tilt", one.is_large()},
                    {"predicted_variance", one.found.figure_of_merit},
                    {"predicted_variance_error", one.found.figure_error},
                    {"parameters", std::move(of_parameters)}});
  }
  return {{"draws", options.planned.draws},          {"sensor_noise_deg", options.planned.sensor_noise_deg},
          {"prior_start_s", options.priors.start_s}, {"prior_gain", options.priors.gain},
          {"parameters", std::move(parameters)},     {"protocols", std::move(list)}};
}

std::string design_text(const std::vector<Planned>& all, const sim::ParameterTable& table) {
  std::size_t width = 8;
  for (const Planned& one : all) width = std::max(width, one.name.size());
  const auto padded = [&](const std::string& text) { return text + std::string(width - text.size(), ' '); };
  std::string text = padded("protocol") + "  length  tilt";
  for (const sim::ParameterInfo& info : table) text += format(" %9s", info.name.c_str());
  text += "  variance\n" + padded("") + "       s   deg";
  for (const sim::ParameterInfo& info : table) text += format(" %9s", info.unit.c_str());
  text += "\n" + padded("(before)") + "             ";
  for (std::size_t p = 0; p < table.size(); ++p) text += format(" %9.3g", all.front().found.prior_sd[p]);
  text += "     1\n";
  for (const Planned& one : all) {
    text += padded(one.name) + format(" %7.1f %5.2f", one.protocol.duration_s(), one.peak_to_peak_deg);
    for (const double sd : one.found.sd) text += format(" %9.3g", sd);
    text += format("  %.4f +- %.4f\n", one.found.figure_of_merit, one.found.figure_error);
  }
  return text;
}

/// Returns the recommendation: among the protocols without a large tilt, if there is one.
std::string recommendation(const std::vector<Planned>& all) {
  const bool all_large = std::ranges::all_of(all, &Planned::is_large);
  const Planned* best = nullptr;
  for (const Planned& one : all)
    if ((all_large || !one.is_large()) && (best == nullptr || one.found.figure_of_merit < best->found.figure_of_merit))
      best = &one;
  const bool some_large = std::ranges::any_of(all, &Planned::is_large);
  std::string text = "'" + best->name + "' leaves the least variance" +
                     (some_large && !all_large ? format(" of the tilts up to %g degrees", usual_tilt_deg) : "") + ".\n";
  for (const Planned& one : all)
    if (one.is_large())
      text += format("'%s' tilts by %.3g degrees: check that a person can stand it.\n", one.name.c_str(),
                     one.peak_to_peak_deg);
  return text;
}

/// Throws Error for a value of a parameter that a protocol's fits fix by convention at another one.
void refuse_other_than_convention(const std::vector<Planned>& all, const std::vector<bool>& is_at,
                                  const std::vector<bool>& is_fixed, const sim::Parameters& at) {
  for (const Planned& one : all) {
    const sim::ParameterTable table = one.protocol.ranges();
    for (std::size_t p = 0; p < table.size(); ++p) {
      const std::optional<double> convention = is_at[p] && !is_fixed[p] ? table[p].convention : std::nullopt;
      if (convention && std::abs(at[p] - *convention) > 1e-9 * std::abs(*convention))
        throw Error(Code::setting_conflict, "--at",
                    format("%s is %g, and fits fix it at %g", table[p].name.c_str(), at[p], *convention) +
                        table[p].unit_after(),
                    format("leave it out, or plan for fits with --fix %s=%g", table[p].name.c_str(), at[p]));
    }
  }
}

/// Prints a note on each given value that is too close to the end of its range to be planned for.
void note_moved(const Planned& one, const std::vector<bool>& is_at, const sim::Parameters& at,
                const sim::ParameterTable& table) {
  for (std::size_t p = 0; p < table.size(); ++p)
    if (is_at[p] && one.found.at && (*one.found.at)[p] != at[p])
      std::cerr << "note: --at: " << table[p].name
                << format(" is %g, near the end of its range; the plan is for %g", at[p], (*one.found.at)[p])
                << table[p].unit_after() << '\n';
}

void run_design(DesignOptions options, const Command& command) {
  std::vector<std::string> inputs;
  std::vector<Planned> all = planned_protocols(options, inputs);
  require_same_controller(all);
  const sim::ParameterTable table = all.front().protocol.ranges();
  sim::Parameters at = table.middle();
  for (std::size_t p = 0; p < table.size(); ++p)
    if (table[p].convention) at[p] = *table[p].convention;
  refuse_other_bodies(options, all);
  const double mgh_nm_rad = all.front().protocol.experiment.body.mgh();
  const std::vector<bool> is_at = read_named_values("--at", options.at, table, mgh_nm_rad, at, at);
  if (!options.at.empty()) options.planned.at = at;
  sim::Parameters fixed(table.size());
  const std::vector<bool> is_fixed = read_named_values("--fix", options.fixed, table, mgh_nm_rad, at, fixed);
  for (std::size_t p = 0; p < table.size(); ++p)
    if (is_fixed[p] && is_at[p] && fixed[p] != at[p])
      throw Error(Code::setting_conflict, "--at, --fix",
                  format("%s is %g and is fixed at %g", table[p].name.c_str(), at[p], fixed[p]),
                  "give one of them, or the same value");
  refuse_other_than_convention(all, is_at, is_fixed, at);
  for (std::size_t p = 0; p < table.size(); ++p)
    if (is_fixed[p]) options.priors.parameters.push_back({.name = table[p].name, .fixed = fixed[p]});
  ProgressBar bar("design", "protocols", static_cast<long long>(all.size()), options.common.quiet);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const posterior::Priors priors = posterior::with_conventions(options.priors, all[i].protocol.ranges());
    all[i].found = posterior::expected_posterior(posterior::Density(all[i].protocol, priors), options.planned);
    bar.update(static_cast<long long>(i) + 1);
  }
  if (!options.common.quiet) note_moved(all.front(), is_at, at, table);
  if (options.common.json) {
    Call call = record_call(command, inputs);
    call.seed = options.planned.seed;
    Json result = design_json(options, all, table);
    add_call(result, call);
    std::cout << print_json(result) << '\n';
    return;
  }
  std::cout << design_text(all, table)
            << "Expected standard deviations of decid fit; variance: predicted over the prior's, mean of the "
               "parameters.\n"
            << recommendation(all);
}

}  // namespace

void add_design(const Command& program) {
  auto options = std::make_shared<DesignOptions>();
  const Command command = program.add_subcommand("design", "Predict the uncertainty of fits for different protocols");
  command.section("Protocols");
  command
      .add_option("--protocol", options->protocols,
                  "Compare this protocol: default, short, or a JSON file; may be repeated; default: default and short")
      .repeatable();
  command
      .add_option("--amplitude", options->amplitudes_deg,
                  "Scale each protocol's stimulus to these tilts, peak to peak in degrees, such as 1 2 4")
      .values(1, 50)
      .range(0.001, 45.0);
  command.add_option("--cycles", options->cycles, "Play each protocol's cycle this many times, such as 1 2 4")
      .values(1, 50)
      .range(1.0, 1000.0);
  add_controller_option(command, options->controller,
                        "Plan for this controller (decid info --controllers); default: the protocols', else dec");
  add_body_options(command, options->body);
  command
      .add_option(
          "--at", options->at,
          "Plan for a person with this parameter, in SI units, or over m g h as Kp/mgh=1; may be repeated; other "
          "parameters: the middle of their ranges; default: people drawn from the prior")
      .repeatable()
      .shown_as("NAME[/mgh]=VALUE");
  command.add_option("--fix", options->fixed, "Plan for fits that fix this parameter; may be repeated")
      .repeatable()
      .shown_as("NAME[/mgh]=VALUE");
  command.section("Recording");
  command
      .add_option("--sensor-noise", options->planned.sensor_noise_deg,
                  "Expect this white measurement noise, in degrees per sample")
      .range(1e-5, 10.0);
  command
      .add_option("--prior-start", options->priors.start_s,
                  "Expect recordings to start up to this many seconds before or after the protocol; 0: known")
      .range(0.0, 0.5);
  command
      .add_option(
          "--prior-gain", options->priors.gain,
          "Expect this relative error of the sway sensor's scale (standard deviation of its logarithm); 0: exact")
      .range(0.0, 0.5);
  command.section("Calculation");
  command.add_option("--draws", options->planned.draws, "Average over this number of simulated people")
      .range(1, 100'000);
  add_seed_option(command, options->planned.seed, "Seed the simulated people");
  command.footer(
      "Examples:\n"
      "  decid design --protocol default --protocol short\n"
      "  decid design --protocol short --amplitude 0.5 1 2 4 --cycles 1 3\n"
      "  decid design --at Kp=839 --at delay=0.15 --protocol mine.json --sensor-noise 0.05 --json");
  run_with(command, options, true, run_design);
}

}  // namespace decid::tools
