// Runs the program as a user does, and keeps what it printed and how it ended; temporary folders for its files.
#pragma once

#include <doctest/doctest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace decid::test {

/// A fresh folder, removed with all it holds.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "decid-test-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = name;
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  std::size_t files() const {
    std::size_t count = 0;
    for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(path_)) ++count;
    return count;
  }

 private:
  std::filesystem::path path_;
};

inline std::string read_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

inline void write_text(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
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

/// Bad input: exit code 2, nothing on standard output, one line of the program's that has all the fragments.
inline void check_refused(const std::string& arguments, std::initializer_list<std::string> fragments) {
  const auto result = run_decid(arguments);
  CAPTURE(arguments);
  CAPTURE(result.err);
  CHECK(result.code == 2);
  CHECK(result.out.empty());
  CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
  CHECK(result.err.starts_with("decid: "));
  for (const std::string& fragment : fragments) {
    CAPTURE(fragment);
    CHECK(result.err.find(fragment) != std::string::npos);
  }
}

/// Returns the rows of numbers of a CSV file whose first line, `header`, has their names.
inline std::vector<std::vector<double>> read_csv(const std::string& path, std::string& header) {
  std::ifstream file(path);
  std::getline(file, header);
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(file, line);) {
    std::istringstream cells(line);
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(std::stod(cell));
  }
  return rows;
}

}  // namespace decid::test
