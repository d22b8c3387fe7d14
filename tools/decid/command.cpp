// Options that several subcommands have.
#include "tools/decid/command.hpp"

#include <omp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <iostream>
#include <set>
#include <sstream>

#include "base/error.hpp"
#include "base/number.hpp"
#include "base/text.hpp"
#include "recording/protocol_file.hpp"
#include "sim/protocol/protocol_json.hpp"
#include "tools/decid/ranks.hpp"

namespace decid::tools {
namespace {

struct Format {
  const char* content;
  const char* ending;
};

/// In the order of Written.
constexpr Format formats[] = {{"JSON", ".json"},
                              {"CSV", ".csv"},
                              {"CSV or a workbook", ".csv"},
                              {"NumPy's arrays", ".npz"},
                              {"NumPy's arrays", ".npz"},
                              {"a page", ".html"},
                              {"an SVG drawing", ".svg"},
                              {"a model", ".safetensors"},
                              {"a network in ONNX", ".onnx"},
                              {"bare samples", ".bin"},
                              {"", ""}};

/// File endings that programs and people know. Any other ending is valid for every format, such as that of a temporary
/// file.
constexpr const char* known_endings[] = {".csv",     ".tsv",  ".txt",         ".dat",  ".json", ".yaml", ".yml", ".xml",
                                         ".npz",     ".npy",  ".mat",         ".html", ".htm",  ".svg",  ".png", ".pdf",
                                         ".md",      ".xls",  ".xlsx",        ".ods",  ".doc",  ".docx", ".odt", ".bin",
                                         ".gz",      ".zip",  ".rds",         ".sav",  ".pkl",  ".hdf5", ".h5",  ".c3d",
                                         ".parquet", ".onnx", ".safetensors", ".c",    ".h"};

/// Returns true for a name of the file, pipe or terminal that is the standard output, except for the null device.
bool is_standard_output(const std::string& name) {
  struct stat named {
  }, output{}, null{};
  const auto are_same = [](const struct stat& a, const struct stat& b) {
    return a.st_dev == b.st_dev && a.st_ino == b.st_ino;
  };
  return !name.empty() && ::stat(name.c_str(), &named) == 0 && ::fstat(STDOUT_FILENO, &output) == 0 &&
         are_same(named, output) && !(::stat("/dev/null", &null) == 0 && are_same(named, null));
}

/// Returns the error in an output's name; empty if the name is valid.
std::string what_is_wrong(const std::string& name, Written written) {
  if (name == "-") return "'-' is not a file; to print results, use --json with the commands that have it";
  const std::filesystem::path path(name);
  const Format& right = formats[static_cast<std::size_t>(written)];
  if (written != Written::folder && (path.filename().empty() || std::filesystem::is_directory(path)))
    return "'" + name + "' is a folder, but the option names a file; give for example '" +
           (path / (std::string("result") + right.ending)).string() + "'";
  const std::string ending = lower_case(path.extension().string());
  const bool same = ending == right.ending || (written == Written::html && ending == ".htm") ||
                    (written == Written::draws && ending == ".csv") || (written == Written::table && ending == ".xlsx");
  const bool is_text = (written == Written::csv || written == Written::table) && (ending == ".txt" || ending == ".dat");
  if (same || is_text || std::ranges::count(known_endings, ending) == 0) return "";
  if (written == Written::folder)
    return std::filesystem::is_directory(path)
               ? ""
               : "'" + name + "' would be a folder but ends in " + ending + " like a file; give the name of a folder";
  return "'" + name + "' would hold " + right.content + " but ends in " + ending + "; call it '" +
         std::filesystem::path(path).replace_extension(right.ending).string() + "'";
}

}  // namespace

void add_common_options(const Command& command, CommonOptions& options, bool prints_figures) {
  command
      .add_option("--threads", options.threads,
                  "Use this many threads; default: all cores; results do not depend on it")
      .range(1, 1024)
      .section("Advanced")
      .unrecorded();
  command.add_flag("--quiet", options.quiet, "Print results and errors only").section("Output").unrecorded();
  if (prints_figures)
    command.add_flag("--json", options.json, "Print one JSON object on standard output").section("Output").unrecorded();
}

std::optional<Silenced> apply(CommonOptions& options, const Command& command) {
  share_processors();
  if (options.threads > 0) omp_set_num_threads(options.threads);
  options.quiet = options.quiet || !is_root();
  const auto outputs = command.outputs();
  const auto printed = std::ranges::find_if(outputs, [](const auto& one) { return is_standard_output(one.second); });
  if (printed == outputs.end()) return {};
  if (options.json)
    throw Error(Code::setting_conflict, "--json",
                "prints on the standard output, to which " + printed->first + " writes", "leave one of them out");
  return std::optional<Silenced>(std::in_place, std::cout);
}

void add_protocol_options(const Command& command, ProtocolOptions& options) {
  command.add_option("--protocol", options.name, "Simulate this protocol: default, short, or a JSON file");
  add_controller_option(command, options.controller,
                        "Simulate this controller (decid info --controllers); default: the protocol's, else dec");
  command
      .add_option("--sensor-noise", options.sensor_noise_deg,
                  "Add measurement noise with this standard deviation in degrees, or, for two numbers LOW HIGH, one "
                  "drawn between them for each trial; default: the protocol's")
      .values(1, 2);
}

void add_seed_option(const Command& command, std::uint64_t& seed, const std::string& description) {
  // Always decimal: CLI11 takes 010 for octal.
  const auto to_decimal = [](std::string& text) -> std::string {
    const std::optional<std::uint64_t> value = number_from<std::uint64_t>(text);
    if (!value) return "'" + text + "' is not a whole number from 0 to 18446744073709551615";
    text = std::to_string(*value);
    return {};
  };
  command.add_option("--seed", seed, description).rewritten(to_decimal, "UINT").section("Advanced");
}

namespace {

std::set<std::string>& added_outputs() {
  static std::set<std::string> names;
  return names;
}

}  // namespace

std::vector<std::string> output_options() {
  return {added_outputs().begin(), added_outputs().end()};
}

Option add_output_option(const Command& command, const std::string& names, std::string& output, Written written,
                         const std::string& description) {
  std::istringstream stream(names);
  for (std::string name; std::getline(stream, name, ',');) added_outputs().insert(name);
  const auto check = [written](std::string& text) { return what_is_wrong(text, written); };
  return command.add_option(names, output, description).rewritten(check, "").section("Output").unrecorded().output();
}

void make_output_folder(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  // Remove a slash at the end, because no file name follows it.
  const fs::path path = folder.filename().empty() ? folder.parent_path() : folder;
  std::error_code error;
  if (fs::is_directory(path, error)) return;
  if (fs::exists(path, error))
    throw Error(Code::file_unwritable, folder.string(), "is a file", "give the name of a folder");
  const fs::path around = path.parent_path();
  if (!around.empty() && !fs::exists(around, error))
    throw Error(Code::file_unwritable, folder.string(), "its folder does not exist",
                "create the folder " + around.string() + " first");
  if (!fs::create_directory(path, error) && !fs::is_directory(path))
    throw Error(Code::file_unwritable, folder.string(), "cannot be created as a folder: " + error.message(),
                "choose one in a folder that you may write to");
}

std::filesystem::path locate(const std::filesystem::path& name) {
  std::error_code error;
  const std::filesystem::path place = std::filesystem::weakly_canonical(name, error);
  return error ? name : place;
}

void refuse_same_file(const std::string& output, const std::vector<std::string>& others) {
  if (output.empty()) return;
  for (const std::string& other : others)
    if (!other.empty() && locate(output) == locate(other))
      throw Error(Code::file_exists, output, "is already read or written by this call", "give the output another name");
}

Option add_controller_option(const Command& command, std::string& controller, const std::string& description) {
  std::vector<std::string> names;
  for (const sim::BodyModel* model : sim::body_models()) names.push_back(model->name);
  return command.add_option("--controller", controller, description).one_of(names);
}

Option add_controller_of_model(const Command& command, std::string& controller) {
  return add_controller_option(command, controller,
                               "Require a model of this controller (decid info --controllers); default: any");
}

void require_controller(const std::string& controller, const sim::Protocol& model, const std::string& name) {
  const std::string& own = model.experiment.body_model->name;
  if (!controller.empty() && controller != own)
    throw Error(Code::setting_conflict, "--controller", "is " + controller + ", and " + name + " was trained on " + own,
                "give a model of this controller with --model, or leave --controller out");
}

sim::Protocol read_protocol(const std::string& name, bool quiet, std::vector<std::string>* files,
                            const std::string& controller) {
  Warnings warnings;
  sim::Protocol protocol = recording::load_protocol(name, files, &warnings, controller);
  for (const Warning& warning : warnings)
    if (!quiet) std::cerr << "note: the tilt of " << name << ": " << warning.text << '\n';
  return protocol;
}

void set_sensor_noise(sim::Protocol& protocol, const std::vector<double>& levels_deg) {
  if (levels_deg.empty()) return;
  const double low = levels_deg.front(), high = levels_deg.back();
  const auto refuse = [](const std::string& problem, const std::string& remedy) {
    throw Error(Code::setting_out_of_range, "--sensor-noise", problem, remedy);
  };
  for (const double level : levels_deg)
    if (!(level >= 0.0 && level <= 90.0)) refuse(format("is %g degrees", level), "give 0 to 90");
  if (low > high) refuse(format("is %g %g", low, high), format("give the smaller level first: %g %g", high, low));
  if (low == 0.0 && high > 0.0)
    refuse(format("is 0 %g, and levels are drawn log-uniformly", high), "give a smallest level above 0");
  protocol.noise.sensor = {low, high};
}

sim::Protocol ProtocolOptions::load(bool quiet, std::vector<std::string>* files) const {
  sim::Protocol protocol = read_protocol(name, quiet, files, controller);
  set_sensor_noise(protocol, sensor_noise_deg);
  protocol.validate();
  return protocol;
}

std::string in_sentence(const sim::ParameterInfo& info) {
  std::string text = info.description;
  text[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(text[0])));
  return text.ends_with(info.name) ? text : text + " (" + info.name + ")";
}

}  // namespace decid::tools
