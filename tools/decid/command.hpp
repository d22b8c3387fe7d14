// What the subcommands share: options that all have, and the functions that add each command to the program.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/protocol/protocol.hpp"
#include "tools/decid/options.hpp"

namespace decid::tools {

struct CommonOptions {
  int threads = 0;  ///< 0: all cores
  bool quiet = false;
  bool json = false;
};

/// Adds --threads, --quiet and, for commands that print figures, --json.
void add_common_options(const Command& command, CommonOptions& options, bool prints_figures);
/// Applies --threads. Of several ranks only rank 0 says anything.
void apply(CommonOptions& options);

/// --protocol and --sensor-noise of the commands that simulate many trials.
struct ProtocolOptions {
  std::string name = "default";
  std::vector<double> sensor_noise_deg;  ///< one level, or a range; empty: the protocol's own

  /// As read_protocol().
  sim::Protocol load(bool quiet, std::vector<std::string>* files = nullptr) const;
};
void add_protocol_options(const Command& command, ProtocolOptions& options);
/// The protocol of a name or file. Prints on standard error what was left out of a measured tilt's file, unless
/// `quiet`. files, unless null: gets the files that were read.
sim::Protocol read_protocol(const std::string& name, bool quiet, std::vector<std::string>* files = nullptr);

/// --seed, from 0 to 2^64 - 1.
void add_seed_option(const Command& command, std::uint64_t& seed, const std::string& description);

/// What a command writes under a name that it is given.
enum class Written { json, csv, npz, html, svg, safetensors, onnx, samples, folder };

/// `names`: "-o,--output", or of what is written besides. Refuses a name that ends like another format, which readers
/// would take it for, a folder where a file is written, and "-": nothing else stands for standard output either.
Option add_output_option(const Command& command, const std::string& names, std::string& output, Written written,
                         const std::string& description);

/// The folder that is written to, made if it is missing. Throws Error if it is something else or cannot be made: the
/// folder that it lies in must be there, as for a file.
void make_output_folder(const std::filesystem::path& folder);

/// Returns what a name leads to, links followed. A pipe ("/dev/fd/63") leads to no place: its name is returned.
std::filesystem::path place_of(const std::filesystem::path& name);

/// Throws Error if `output` is one of `others`, files that are read or written too and would be lost. Empty names are
/// ignored.
void refuse_same_file(const std::string& output, const std::vector<std::string>& others);

/// Each adds one subcommand whose callback does the work. Bad input: Error. Anything else: any other exception.
void add_simulate(const Command& program);
void add_stimulus(const Command& program);
void add_dataset(const Command& program);
void add_train(const Command& program);
void add_evaluate(const Command& program);
void add_identify(const Command& program);
void add_fit(const Command& program);
void add_calibrate(const Command& program);
void add_compare(const Command& program);
void add_study(const Command& program);
void add_image(const Command& program);
void add_info(const Command& program);
void add_selftest(const Command& program);
void add_export(const Command& program);

}  // namespace decid::tools
