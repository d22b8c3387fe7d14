// Shared fixtures: temporary folders, files, and checks of errors.
#pragma once

#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>

#include "base/error.hpp"
#include "base/warning.hpp"
#include "tests/near.hpp"

namespace decid::test {

#ifndef __wasi__  // which has no temporary folder
/// A fresh folder below the system's temporary folder, removed with all it holds.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    // A unique name: process numbers repeat, and a killed test leaves its folder.
    std::string name = std::filesystem::temp_directory_path() / "decid-test-XXXXXX";
    REQUIRE(::mkdtemp(name.data()) != nullptr);
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(path_), {}));
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};
#endif

inline std::filesystem::path write_text(const std::filesystem::path& path, const std::string& text) {
  // ext4 writes a file that was truncated to the disk when it is closed, which takes milliseconds; a new one later.
  if (std::filesystem::symlink_status(path).type() == std::filesystem::file_type::regular)
    std::filesystem::remove(path);
  std::ofstream stream(path, std::ios::binary);
  stream << text;
  REQUIRE(stream.good());
  return path;
}

inline std::string read_text(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  REQUIRE(stream.good());
  return {std::istreambuf_iterator<char>(stream), {}};
}

inline bool contains(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

/// Returns true if a warning of a recording, or of a result, has the part.
template <class Warned>
bool warns(const Warned& warned, std::string_view part) {
  return std::ranges::any_of(warned.warnings, [&](const auto& warning) { return contains(warning.text, part); });
}

/// Returns true if a warning has the code.
inline bool has(const Warnings& warnings, std::string_view code) {
  return std::ranges::any_of(warnings, [&](const Warning& warning) { return warning.code == code; });
}

/// Calls f, which must throw an Error, and returns it.
template <class F>
Error error_of(const F& f) {
  try {
    f();
  } catch (const Error& error) {
    return error;
  }
  throw std::logic_error("no Error was thrown");
}

template <class F>
std::string message_of(const F& f) {
  return error_of(f).what();
}

/// Calls f, which must throw an Error of this code with a remedy, and with the fact in its message if one is given: a
/// file, line, key or number. tests/golden/messages.txt has the sentences.
template <class F>
void check_error(const F& f, Code code, std::string_view fact = {}, const char* file = __builtin_FILE(),
                 int line = __builtin_LINE()) {
  const Error error = error_of(f);
  INFO("called in " << file << ", line " << line);
  INFO("message: " << error.what());
  CHECK(std::string(name(error.code())) == name(code));
  CHECK(contains(error.what(), fact));
  CHECK_FALSE(error.remedy().empty());
}

}  // namespace decid::test
