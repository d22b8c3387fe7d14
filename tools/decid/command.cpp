// Options that several subcommands have.
#include "tools/decid/command.hpp"

#include <omp.h>

#include <charconv>
#include <filesystem>

#include "base/error.hpp"
#include "dataset/recording/protocol_file.hpp"
#include "sim/protocol_json.hpp"

namespace decid::tools {

void add_common_options(const Command& command, CommonOptions& options, bool prints_figures) {
  command.add_option("--threads", options.threads, "Threads to use; default: all cores. The result is the same")
      .range(1, 1024);
  command.add_flag("--quiet", options.quiet, "No progress and no messages, only results and errors");
  if (prints_figures) command.add_flag("--json", options.json, "Print one JSON object on standard output");
}

void apply(const CommonOptions& options) {
  if (options.threads > 0) omp_set_num_threads(options.threads);
}

void add_protocol_options(const Command& command, ProtocolOptions& options) {
  command.add_option("--protocol", options.name, "default, short, or a JSON file").show_default();
  command
      .add_option("--sensor-noise", options.sensor_noise_deg,
                  "Standard deviation of the sway sensor's noise in degrees, or LOW HIGH to draw one for each trial; "
                  "default: the protocol's, which is none for default and short")
      .values(1, 2);
}

void add_seed_option(const Command& command, std::uint64_t& seed, const std::string& description) {
  // Always decimal: CLI11 takes 010 for octal.
  const auto to_decimal = [](std::string& text) -> std::string {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size())
      return "'" + text + "' is not a whole number from 0 to 18446744073709551615";
    text = std::to_string(value);
    return {};
  };
  command.add_option("--seed", seed, description).show_default().rewritten(to_decimal, "UINT");
}

Option add_output_option(const Command& command, std::string& output, const std::string& description) {
  const auto refuse_dash = [](std::string& text) -> std::string {
    return text == "-" ? "'-' is no file; commands that have --json print their results with it" : "";
  };
  return command.add_option("-o,--output", output, description).rewritten(refuse_dash, "");
}

void refuse_same_file(const std::string& output, const std::vector<std::string>& others) {
  if (output.empty()) return;
  const auto place = [](const std::string& name) { return std::filesystem::weakly_canonical(name); };
  for (const std::string& other : others)
    if (!other.empty() && place(output) == place(other))
      throw Error(output, "is read or written already in this call", "give the output another name");
}

sim::Protocol ProtocolOptions::load(std::vector<std::string>* files) const {
  sim::Protocol protocol = dataset::load_protocol(name, files);
  if (!sensor_noise_deg.empty()) protocol.noise.sensor = {sensor_noise_deg.front(), sensor_noise_deg.back()};
  protocol.validate();
  return protocol;
}

}  // namespace decid::tools
