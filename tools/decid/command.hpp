// Options that all subcommands share, and the functions that add each command to the program.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "sim/protocol/protocol.hpp"
#include "tools/decid/options.hpp"
#include "tools/decid/ranks.hpp"

namespace decid::tools {

struct CommonOptions {
  int threads = 0;  ///< 0: all cores
  bool quiet = false;
  bool json = false;
};

/// Adds --threads, --quiet and, for commands that print figures, --json.
void add_common_options(const Command& command, CommonOptions& options, bool prints_figures);
/// Applies --threads. With several ranks, only rank 0 prints. If an output option names the standard output, the
/// command prints no text there while the returned object lives; throws Error for --json beside it.
[[nodiscard]] std::optional<Silenced> apply(CommonOptions& options, const Command& command);
/// Adds the common options, and sets the command's work: run(options, command) or run(options).
template <class Options, class Run>
void run_with(const Command& command, const std::shared_ptr<Options>& options, bool prints_figures, Run run) {
  add_common_options(command, options->common, prints_figures);
  command.callback([=] {
    const std::optional<Silenced> silenced = apply(options->common, command);
    if constexpr (std::is_invocable_v<Run, Options&, const Command&>)
      run(*options, command);
    else
      run(*options);
  });
}

/// Sets the measurement noise of --sensor-noise: one level, or a range; without levels it stays. Throws Error for a
/// level below 0 or above 90 degrees, and for a range that does not rise or begins at 0.
void set_sensor_noise(sim::Protocol& protocol, const std::vector<double>& levels_deg);

/// The options --protocol and --sensor-noise of the commands that simulate many trials.
struct ProtocolOptions {
  std::string name = "default", controller;  ///< controller: empty for the protocol's
  std::vector<double> sensor_noise_deg;      ///< one level, or a range; empty: the protocol's own

  /// Loads the protocol as read_protocol() does.
  sim::Protocol load(bool quiet, std::vector<std::string>* files = nullptr) const;
};
void add_protocol_options(const Command& command, ProtocolOptions& options);
/// Returns the protocol with this name or from this file. Prints on standard error which parts of a measured tilt's
/// file it left out, unless `quiet`. files: receives the names of the files that were read, unless null. controller: as
/// recording::load_protocol takes it.
sim::Protocol read_protocol(const std::string& name, bool quiet, std::vector<std::string>* files = nullptr,
                            const std::string& controller = {});
/// Adds --controller: the name of a controller.
Option add_controller_option(const Command& command, std::string& controller, const std::string& description);
/// Adds --controller to a command with --model, whose file determines the controller.
Option add_controller_of_model(const Command& command, std::string& controller);
/// Throws Error if `controller` is given and is not the model's. name: the model's, for people.
void require_controller(const std::string& controller, const sim::Protocol& model, const std::string& name);

/// Adds --seed, from 0 to 2^64 - 1.
void add_seed_option(const Command& command, std::uint64_t& seed, const std::string& description);

/// The format of an output file, or a folder. table: CSV or a workbook. draws: .npz or
/// CSV.
enum class Written { json, csv, table, npz, draws, html, svg, safetensors, onnx, samples, folder };

/// Adds the option `names`: "-o,--output", or the option of another output file. Rejects a name with the ending of
/// another format, because readers would take the file for that format. Rejects a folder where the command writes a
/// file. Rejects "-", because no output option accepts it for standard output. The option is unrecorded.
Option add_output_option(const Command& command, const std::string& names, std::string& output, Written written,
                         const std::string& description);

/// Returns the names of all options that add_output_option() added to any command, such as "-o" and "--output".
std::vector<std::string> output_options();

/// Creates the output folder if it is missing. Throws Error if the path is not a folder or decid cannot create it. The
/// parent folder must exist, as for a file.
void make_output_folder(const std::filesystem::path& folder);

/// Returns the path to which a name leads, with links followed. A pipe ("/dev/fd/63") leads to no path: returns its
/// name.
std::filesystem::path locate(const std::filesystem::path& name);

/// Throws Error if `output` is one of `others`: files that the command also reads or writes and that would be lost.
/// Ignores empty names.
void refuse_same_file(const std::string& output, const std::vector<std::string>& others);

/// Each function adds one subcommand whose callback does the work. The callback throws Error for bad input and any
/// other exception for other failures.
void add_simulate(const Command& program);
void add_stimulus(const Command& program);
void add_dataset(const Command& program);
void add_train(const Command& program);
void add_evaluate(const Command& program);
void add_identify(const Command& program);
void add_fit(const Command& program);
void add_rerun(const Command& program);
void add_calibrate(const Command& program);
void add_compare(const Command& program);
void add_study(const Command& program);
void add_design(const Command& program);
void add_power(const Command& program);
void add_image(const Command& program);
void add_info(const Command& program);
void add_selftest(const Command& program);
void add_export(const Command& program);

/// Returns a parameter as a part of a sentence: "active stiffness (Kp)".
std::string in_sentence(const sim::ParameterInfo& info);

}  // namespace decid::tools
