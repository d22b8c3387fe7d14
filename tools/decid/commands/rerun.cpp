// decid rerun: computes a result again from its JSON, which names the call, its options and its inputs.
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/files/sha256.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "tools/decid/command.hpp"

namespace decid::tools {
namespace {

struct RerunOptions {
  CommonOptions common;
  std::string result, output;
};

/// The call that wrote a result.
struct Call {
  std::string command;
  std::vector<std::string> arguments;
};

/// Throws Error unless the inputs are those of the call, and this decid wrote the result.
Call read_call(const std::string& path, const std::string& content) {
  const Json all = parse_json(content, path);
  const auto is_text = [](const Json& value) { return value.is_string(); };
  const bool is_result = all.is_object() && all.contains("command") && all["command"].is_string() &&
                         all.contains("arguments") && all["arguments"].is_array() &&
                         std::ranges::all_of(all["arguments"], is_text) && all.contains("inputs") &&
                         all["inputs"].is_array() && all.contains("decid");
  if (!is_result || (all["command"] != "identify" && all["command"] != "fit"))
    throw Error(Code::file_unsupported, path, "does not say which call wrote it",
                "give the JSON of decid identify or decid fit");
  if (all["decid"] != version)
    throw Error(Code::file_differs, path, "was written by decid " + all["decid"].dump(),
                std::string("this is decid ") + version + "; use that version");
  for (const Json& input : all["inputs"]) {
    if (!input.is_object() || !input.contains("file") || !input.contains("sha256"))
      throw Error(Code::file_damaged, path, "names its inputs in another form",
                  "give the JSON of decid identify or decid fit");
    const std::string file = input["file"].get<std::string>();
    const Json& hash = input["sha256"];
    const bool is_stream = file == "-" || std::filesystem::exists(file);
    if (hash.is_null() && !is_stream) continue;  // it was missing then, too
    if (hash.is_null())
      throw Error(Code::not_supported, file, "is not a file whose content is known",
                  "save it as a file, and run the call again");
    if (sha256(read_file(file)) != hash.get<std::string>())
      throw Error(Code::file_differs, file, "is not the file that " + path + " was computed from", "restore that file");
  }
  return {all["command"].get<std::string>(), all["arguments"].get<std::vector<std::string>>()};
}

/// Discards standard output for its lifetime: the call prints its results, and rerun writes them to a file.
class Silence {
 public:
  Silence() : before_(std::cout.rdbuf(discarded_.rdbuf())) {}
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;
  ~Silence() { std::cout.rdbuf(before_); }

 private:
  std::ostringstream discarded_;
  std::streambuf* before_;
};

/// Runs a command in this process. Throws its errors.
void run(const Call& call, const std::string& output, const CommonOptions& common) {
  std::vector<std::string> words{"decid", call.command};
  words.insert(words.end(), call.arguments.begin(), call.arguments.end());
  words.insert(words.end(), {"--output", output});
  if (common.quiet) words.emplace_back("--quiet");
  if (common.threads > 0) words.insert(words.end(), {"--threads", std::to_string(common.threads)});
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  const Program program("decid", "", version);
  add_identify(program.top());
  add_fit(program.top());
  const Silence silence;
  try {
    program.parse(static_cast<int>(pointers.size()), pointers.data());
  } catch (const UsageError& error) {
    throw Error(Code::setting_malformed, "decid rerun", error.message, "was the JSON edited?");
  }
}

void run_rerun(const RerunOptions& options) {
  const std::string before = read_file(options.result);
  refuse_same_file(options.output, {options.result});
  const Call call = read_call(options.result, before);
  const std::filesystem::path folder = std::filesystem::temp_directory_path();
  PendingFile temporary(options.output.empty() ? folder / "decid-rerun.json" : std::filesystem::path(options.output));
  std::optional<Error> failed;  // of some recordings, as in the first call
  try {
    run(call, temporary.path().string(), options.common);
  } catch (const Error& error) {
    if (read_file(temporary.path()).empty()) throw;
    failed = error;
  }
  std::error_code ignored;
  std::filesystem::remove(temporary.path().string() + ".journal", ignored);  // a fit with errors leaves it
  const bool same = read_file(temporary.path()) == before;
  if (!options.output.empty()) temporary.commit();
  if (!same) throw std::runtime_error(options.result + ": the call gives other bytes here");
  if (!options.common.quiet) std::cerr << "decid: " << options.result << ": reproduced, the same bytes\n";
  if (failed) throw *failed;
}

}  // namespace

void add_rerun(const Command& program) {
  auto options = std::make_shared<RerunOptions>();
  const Command command =
      program.add_subcommand("rerun", "Compute the JSON of decid identify or decid fit again, and compare the bytes");
  command.section("Input");
  command.add_option("result", options->result, "Repeat the call that wrote this JSON, from the same folder")
      .required();
  add_output_option(command, "-o,--output", options->output, Written::json, "Write the new JSON to this file");
  add_common_options(command, options->common, false);
  command.footer(
      "Examples:\n"
      "  decid rerun result.json\n"
      "  decid rerun result.json -o again.json\n"
      "  decid rerun result.json --quiet && echo the same bytes\n"
      "Inputs that have changed, and another version of decid, are refused; other bytes end with exit code 1.");
  command.callback([options] {
    apply(options->common);
    run_rerun(*options);
  });
}

}  // namespace decid::tools
