// decid rerun: computes a result again from its JSON, which names the call, its options and its inputs.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>
#include <sstream>
#include <stdexcept>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "identify/result.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/interrupt.hpp"
#include "tools/report/json/report_json.hpp"

namespace decid::tools {
namespace {

struct RerunOptions {
  CommonOptions common;
  std::string result, output;
};

/// A command whose JSON names the call.
struct Repeatable {
  const char* name;                     ///< as Command::name()
  void (*add)(const Command& program);  ///< adds it to the program
  bool prints = false;                  ///< --json prints its JSON, which is not in its --output
  const char* output = "";              ///< a name for its --output; empty: it has none
  const char* output_key = "";          ///< the key of the JSON that names the output, if there is one
};
constexpr Repeatable rerun_commands[] = {{"identify", add_identify, false, "result.json"},
                                         {"fit", add_fit, false, "result.json"},
                                         {"calibrate", add_calibrate, false, "result.json"},
                                         {"compare", add_compare, false, "result.json"},
                                         {"study", add_study, false, "study"},
                                         {"design", add_design, true},
                                         {"power", add_power, true},
                                         {"evaluate", add_evaluate, true},
                                         {"info", add_info, true},
                                         {"dataset", add_dataset, true, "data.npz", "file"},
                                         {"train", add_train, true, "model.safetensors", "model"},
                                         {"export c", add_export, true, "exported"},
                                         {"export controller", add_export, true, "exported"}};
constexpr const char* wanted_file = "give a JSON that decid wrote with --output or --json";

const Repeatable* find_repeatable(const Json& command) {
  const auto* found = std::ranges::find_if(rerun_commands, [&](const Repeatable& one) { return command == one.name; });
  return found == std::end(rerun_commands) ? nullptr : found;
}

/// Keys of computing times, which differ from call to call, and of the threads that they are of.
constexpr const char* timed_keys[] = {"seconds", "mean_s", "max_s", "threads"};

/// Returns true for an element of "inputs": a name, and a hash or null.
bool is_input(const Json& input) {
  return input.is_object() && input.contains("file") && input["file"].is_string() && input.contains("sha256") &&
         (input["sha256"].is_string() || input["sha256"].is_null());
}

/// Throws Error for a result that its call alone does not determine.
void refuse_unrepeatable(const std::string& path, const Json& all) {
  if (all["command"] == "selftest")
    throw Error(Code::not_supported, path, "is of a self-test, which is the machine's own",
                "run decid selftest on each machine");
  if (all["command"] == "train" && all.contains("extensions"))
    throw Error(
        Code::not_supported, path, "is of a training that --resume took to more epochs",
        "repeat all its calls with another --output, and compare weights_sha256; extensions has the epochs that "
        "were planned before");
}

/// Throws Error unless the inputs are those of the call, and this decid wrote the result.
Call read_call(const std::string& path, const std::string& content) {
  Json all;
  try {
    all = parse_json(content, path);
  } catch (const Error&) {
    throw Error(Code::file_unsupported, path, "is not JSON", wanted_file);
  }
  const auto is_text = [](const Json& value) { return value.is_string(); };
  const bool is_result = all.is_object() && all.contains("command") && all["command"].is_string() &&
                         all.contains("arguments") && all["arguments"].is_array() &&
                         std::ranges::all_of(all["arguments"], is_text) && all.contains("inputs") &&
                         all["inputs"].is_array() && all.contains("decid");
  if (is_result) refuse_unrepeatable(path, all);
  if (!is_result || find_repeatable(all["command"]) == nullptr)
    throw Error(Code::file_unsupported, path, "does not say which call wrote it", wanted_file);
  if (all["decid"] != version)
    throw Error(Code::file_differs, path, "was written by decid " + all["decid"].dump(),
                std::string("this is decid ") + version + "; use that version");
  for (const Json& input : all["inputs"]) {
    if (!is_input(input)) throw Error(Code::file_damaged, path, "names its inputs in another form", wanted_file);
    const std::string file = input["file"].get<std::string>();
    const Json& hash = input["sha256"];
    const bool is_there = file == "-" || path_exists(file);
    if (hash.is_null() && !is_there) continue;  // it was missing then, too
    if (std::error_code ignored; hash.is_null() && std::filesystem::is_regular_file(file, ignored))
      throw Error(Code::file_differs, file, "had no content known to " + path + ", and is there now",
                  "move it away if it was missing; for a pipe run the call again with a file");
    if (hash.is_null())
      throw Error(Code::not_supported, file, "is not a file whose content is known",
                  "save it as a file, and run the call again");
    if (!is_there && file.find("\xEF\xBF\xBD") != std::string::npos)
      throw Error(Code::file_missing, file, "is an input of " + path + " whose name was not UTF-8",
                  "rename the file, and run the first call again");
    if (!is_there)
      throw Error(Code::file_missing, file, "is an input of " + path + ", and is not there",
                  "run decid rerun in the folder of the first call, or restore the file");
    if (hash_file(file) != hash.get<std::string>())
      throw Error(Code::file_differs, file, "is not the file that " + path + " was computed from", "restore that file");
  }
  return {all["command"].get<std::string>(), all["arguments"].get<std::vector<std::string>>(), {}, {}};
}

/// Collects standard output for its lifetime.
class Captured {
 public:
  Captured() : before_(std::cout.rdbuf(text_.rdbuf())) {}
  Captured(const Captured&) = delete;
  Captured& operator=(const Captured&) = delete;
  ~Captured() { std::cout.rdbuf(before_); }
  std::string text() const { return text_.str(); }

 private:
  std::ostringstream text_;
  std::streambuf* before_;
};

/// Runs a command in this process. Returns what it prints. Throws its errors. output: empty for a command that has
/// none.
std::string run(const Call& call, const std::string& output, const CommonOptions& common) {
  const Repeatable& repeatable = *find_repeatable(call.command);
  std::vector<std::string> words{"decid"};
  std::istringstream names(call.command);
  for (std::string name; names >> name;) words.push_back(name);
  const auto files = std::ranges::find(call.arguments, "--");  // whose names begin with a hyphen, if they follow this
  words.insert(words.end(), call.arguments.begin(), files);
  if (repeatable.prints) words.emplace_back("--json");
  if (!output.empty()) words.insert(words.end(), {"--output", output});
  if (common.quiet) words.emplace_back("--quiet");
  if (common.threads > 0) words.insert(words.end(), {"--threads", std::to_string(common.threads)});
  words.insert(words.end(), files, call.arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  const Program program("decid", "", version);
  repeatable.add(program.top());
  const Captured printed;
  try {
    program.parse(static_cast<int>(pointers.size()), pointers.data());
  } catch (const UsageError& error) {
    throw Error(Code::setting_malformed, "decid rerun", error.message, "was the JSON edited?");
  }
  return printed.text();
}

/// A folder for what the call writes.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "decid-rerun-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr)
      throw Error(Code::file_unwritable, name, "cannot be created", "set TMPDIR to a folder with space");
    path_ = name;
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Returns the JSON of the call, computed again; other text, or none, if its arguments ask for help. Recordings that
/// fail, as in the first call, have their error there.
std::string compute_again(const Call& call, const CommonOptions& common) {
  const Repeatable& repeatable = *find_repeatable(call.command);
  const std::string name = repeatable.output;
  if (name.empty()) return run(call, {}, common);
  const ScratchFolder scratch;
  const std::filesystem::path output = scratch.path() / name, json = name == "study" ? output / "study.json" : output;
  try {
    std::string printed = run(call, output.string(), common);
    if (repeatable.prints) return printed;
  } catch (const Error&) {
    if (repeatable.prints || !path_exists(json)) throw;
  } catch (const std::runtime_error&) {
    if (interrupted()) throw std::runtime_error("stopped; decid rerun keeps nothing of it");
    throw;
  }
  return path_exists(json) ? read_file(json) : std::string();
}

/// Throws Error if the call gave no JSON, as --help in edited arguments does.
void require_json(const std::string& result, const Call& call, const std::string& path) {
  try {
    parse_json(result, path);
  } catch (const Error&) {
    throw Error(Code::setting_malformed, path,
                "has arguments that give no result: " + one_line(joined(call.arguments, " ")), "was the JSON edited?");
  }
}

/// Gives the output in the new JSON the name that it has in the first one.
std::string with_first_output(const std::string& now, const std::string& before, const Call& call) {
  const char* const key = find_repeatable(call.command)->output_key;
  const Json first = parse_json(before, "the result");
  if (*key == '\0' || !first.contains(key)) return now;
  Json again = parse_json(now, "the new result");
  again[key] = first[key];
  return print_json(again) + '\n';
}

void remove_times(Json& json) {
  if (json.is_object())
    for (const char* key : timed_keys) json.erase(std::string(key));
  if (json.is_structured())
    for (Json& part : json) remove_times(part);
}

/// Returns true if only computing times differ.
bool alike_but_for_times(const std::string& before, const std::string& now) {
  Json first = parse_json(before, "the result"), second = parse_json(now, "the new result");
  remove_times(first);
  remove_times(second);
  return first == second;
}

void run_rerun(const RerunOptions& options) {
  const std::string before = read_file(options.result);
  refuse_same_file(options.output, {options.result});
  if (!options.output.empty()) PendingFile probe(options.output);  // reports an unwritable place before the work
  const Call call = read_call(options.result, before);
  std::string now = compute_again(call, options.common);
  require_json(now, call, options.result);
  now = with_first_output(now, before, call);
  if (!options.output.empty()) write_file(options.output, now);
  const bool is_same = now == before;
  if (!is_same && !alike_but_for_times(before, now))
    throw std::runtime_error(options.result + ": the call gives other bytes here");
  if (!options.common.quiet)
    std::cerr << "decid: " << options.result
              << (is_same ? ": reproduced, the same bytes\n" : ": reproduced, the same bytes except computing times\n");
}

}  // namespace

void add_rerun(const Command& program) {
  auto options = std::make_shared<RerunOptions>();
  const Command command = program.add_subcommand("rerun",
                                                 "Repeat the call that wrote a JSON, and check that the result is "
                                                 "the same");
  command.section("Input");
  command.add_option("result", options->result, "Repeat the call that wrote this JSON, from the same folder")
      .required();
  add_output_option(command, "-o,--output", options->output, Written::json, "Write the new JSON to this file");
  command.footer(
      "Examples:\n"
      "  decid rerun result.json\n"
      "  decid rerun result.json -o again.json\n"
      "  decid rerun result.json --quiet && echo the same bytes\n"
      "decid writes data sets, models and exported C to a temporary folder, in TMPDIR, and deletes them. "
      "decid refuses inputs that have changed, and results of another version. If the new result differs, the exit "
      "code is 1; computing times may differ. A recording that could not be used is part of the result.");
  run_with(command, options, false, run_rerun);
}

}  // namespace decid::tools
