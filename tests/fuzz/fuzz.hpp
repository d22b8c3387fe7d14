// Shared code of the fuzz targets. They pass the input as a file, and check that a reader reads it or throws a complete
// decid::Error. libFuzzer and the sanitizers check memory, undefined behaviour and time.
#pragma once

#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>

#include "base/error.hpp"
#include "base/files/sha256.hpp"

#define REQUIRE_THAT(condition)                                            \
  do {                                                                     \
    if (!(condition)) {                                                    \
      std::fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition); \
      std::abort();                                                        \
    }                                                                      \
  } while (false)

namespace decid::fuzz {

/// A file of that name, in memory where the system has such files, in a folder that is gone with the process.
class InputFile {
 public:
  explicit InputFile(const char* name) {
    const bool in_memory = ::access("/dev/shm", W_OK) == 0;
    std::string folder =
        (in_memory ? std::filesystem::path("/dev/shm") : std::filesystem::temp_directory_path()) / "decid-fuzz-XXXXXX";
    REQUIRE_THAT(::mkdtemp(folder.data()) != nullptr);
    folder_ = folder;
    path_ = folder_ / name;
  }
  ~InputFile() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  const std::filesystem::path& write(std::string_view content) const {
    std::FILE* file = std::fopen(path_.c_str(), "wb");
    REQUIRE_THAT(file != nullptr);
    REQUIRE_THAT(std::fwrite(content.data(), 1, content.size(), file) == content.size());
    REQUIRE_THAT(std::fclose(file) == 0);
    return path_;
  }
  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_, path_;
};

inline std::string_view to_text(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// Returns the text as an entry of a journal, with its right hash.
inline std::string journal_entry(const std::string& text) {
  const std::uint64_t size = text.size();
  std::string bytes(sizeof size, '\0');
  std::memcpy(bytes.data(), &size, sizeof size);
  return bytes + sha256(text) + text;
}

/// Calls `read`; false if it threw an Error. Anything else that is thrown ends the process.
template <class Read>
bool accepts(const Read& read) {
  try {
    read();
    return true;
  } catch (const Error& error) {
    REQUIRE_THAT(!error.where().empty() && !error.problem().empty() && !error.remedy().empty());
    return false;
  }
}

}  // namespace decid::fuzz
