// Runs the program as a user does, and keeps its output and exit code; temporary folders for its files.
#pragma once

#include <sys/wait.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "tests/helpers.hpp"
#include "tests/tools/report/page_text.hpp"

namespace decid::test {

/// A temporary folder whose file names are strings, as parts of a command.
class Folder : public TemporaryFolder {
 public:
  std::string operator/(const std::string& name) const { return (path() / name).string(); }
};

/// 16 s at 20 Hz: a fit of its recordings takes a sixth of the time that one of the protocol `short` takes.
inline constexpr const char* brief_protocol = R"({"name": "tiny", "sensor_noise_deg": 0.02, "sample_rate_hz": 20,
    "sequence": {"feedback": [0, 0, -1, 1], "start": [0, 0, 0, 1], "state_s": 0.1, "amplitude_deg": 4, "offset_s": 0,
    "cycles": 2}})";

/// Writes the brief protocol to a file; returns its option.
inline std::string with_brief_protocol(const Folder& folder) {
  write_text(folder / "tiny.json", brief_protocol);
  return " --protocol " + folder / "tiny.json" + " ";
}

struct Result {
  int code;
  std::string out, err;
};

/// `arguments` as a shell reads them, with a standard input of their own if they have one; `before`: its commands
/// before the program.
inline Result run_decid(const std::string& arguments, const std::string& before = {}) {
  const Folder folder;
  const std::string command =
      before + "</dev/null " + DECID_PROGRAM + " " + arguments + " >" + folder / "out" + " 2>" + folder / "err";
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_text(folder / "out"), read_text(folder / "err")};
}

/// Runs the program, which must succeed.
inline Result run_ok(const std::string& arguments, const std::string& before = {}) {
  Result result = run_decid(arguments, before);
  CAPTURE(arguments);
  CAPTURE(result.err);
  REQUIRE(result.code == 0);
  return result;
}

/// Runs the program, sends Ctrl-C once the shell's condition holds ("grep -qs epoch $err": its standard error), and
/// expects it to end by that signal. A shell without job control starts children with SIGINT ignored; the program sets
/// its own handler all the same.
inline Result interrupted(const std::string& arguments, const std::string& condition) {
  const Folder folder;
  const std::string command = "err=" + folder / "err" + "; " DECID_PROGRAM " " + arguments + " >" + folder / "out" +
                              " 2>$err & child=$!; while kill -0 $child && ! { " + condition +
                              "; }; do sleep 0.02; done; kill -INT $child; wait $child";
  const int status = std::system(command.c_str());
  Result result{WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_text(folder / "out"), read_text(folder / "err")};
  CAPTURE(result.err);
  REQUIRE(result.code == 130);
  return result;
}

/// Returns the JSON that the program prints. Its exit code may be an error's.
inline nlohmann::json run_json(const std::string& arguments) {
  return nlohmann::json::parse(run_decid(arguments).out);
}

/// Returns the first recording of the JSON that a successful call prints.
inline nlohmann::json first_recording(const std::string& arguments) {
  return nlohmann::json::parse(run_ok(arguments).out).at("recordings").at(0);
}

inline nlohmann::json read_json(const std::string& path) {
  return nlohmann::json::parse(read_text(path));
}

/// Returns a command's JSON without the call that made it.
inline nlohmann::json without_call(nlohmann::json result) {
  for (const char* key : {"decid", "command", "arguments", "seed", "inputs"}) REQUIRE(result.erase(key) == 1);
  return result;
}

/// Checks bad input: exit code 2, nothing on standard output, one line of the program's, with the fact if one is given.
/// tests/golden/messages.txt has the messages.
inline void check_refused(const std::string& arguments, const std::string& fact = "") {
  const auto result = run_decid(arguments);
  CAPTURE(arguments);
  CAPTURE(result.err);
  CHECK(result.code == 2);
  CHECK(result.out.empty());
  CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
  CHECK(result.err.starts_with("decid: "));
  CHECK(contains(result.err, fact));
}

using Cells = std::vector<std::vector<std::string>>;

/// Returns the cells of a table whose cells are single lines (RFC 4180).
inline Cells cells_of(const std::string& text, char separator = ',') {
  Cells rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.ends_with('\r')) line.pop_back();
    std::vector<std::string>& row = rows.emplace_back(1);
    bool quoted = false;
    for (const char c : line) {
      if (c == '"') quoted = !quoted;
      if (c == separator && !quoted) row.emplace_back();
      if (c != '"' && (c != separator || quoted)) row.back() += c;
    }
  }
  return rows;
}

/// Returns a table's cell by the name of its column.
inline std::string cell(const Cells& rows, std::size_t row, const std::string& name) {
  const auto found = std::ranges::find(rows.at(0), name);
  REQUIRE_MESSAGE(found != rows[0].end(), name);
  return rows.at(row).at(static_cast<std::size_t>(found - rows[0].begin()));
}

/// Returns the rows of numbers of a CSV file whose first line, `header`, has their names.
inline std::vector<std::vector<double>> read_csv(const std::string& path, std::string& header) {
  const std::string text = read_text(path);
  header = text.substr(0, text.find('\n'));
  const Cells table = cells_of(text.substr(header.size() + 1));
  std::vector<std::vector<double>> rows;
  for (const std::vector<std::string>& cells : table) {
    rows.emplace_back();
    for (const std::string& cell : cells) rows.back().push_back(std::stod(cell));
  }
  return rows;
}

/// Checks that a page is one whole file that loads nothing; returns its data.
inline nlohmann::json page_data(const std::string& path) {
  const std::string page = read_text(path);
  check_whole(page);
  return nlohmann::json::parse(block_of(page));
}

/// Writes a protocol of 6 s, which trains and identifies quickly, and returns its path.
inline std::string quick_protocol(const Folder& folder) {
  return write_text(folder / "quick.json",
                    R"({"sequence": {"feedback": [0, 0, -1, 1], "start": [0, 0, 0, 1], "offset_s": 0, "cycles": 1}})")
      .string();
}

}  // namespace decid::test
