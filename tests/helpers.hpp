// Shared fixtures: temporary folders, files, and checks of errors.
#pragma once

#include <doctest/doctest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <string>
#include <string_view>

#include "base/error.hpp"
#include "tests/near.hpp"

namespace decid::test {

#ifndef __wasi__  // which has no temporary folder
/// A fresh folder below the system's temporary folder, removed with all it holds.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    // A name that nobody has: process numbers come again, and a killed test leaves its folder.
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

  std::filesystem::path operator/(const char* name) const { return path_ / name; }
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

/// Calls f, which must throw an Error with a remedy whose message has all the parts.
template <class F>
void check_error(const F& f, std::initializer_list<const char*> parts) {
  try {
    f();
  } catch (const Error& error) {
    const std::string message = error.what();
    CHECK_FALSE(error.remedy().empty());
    for (const std::string part : parts) {
      INFO("message: " << message);
      INFO("part: " << part);
      CHECK(contains(message, part));
    }
    return;
  }
  const std::string expected = *parts.begin();
  FAIL_CHECK("no Error was thrown; expected: " << expected);
}

}  // namespace decid::test
