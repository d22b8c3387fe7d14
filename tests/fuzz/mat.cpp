// MAT-files of versions 4 to 7, as they are and with their variables compressed: mutations of a compressed stream alone
// would seldom be one. Version 7.3 is what a child's answer may be; HDF5 itself is not ours to fuzz.
#include <zlib.h>

#include <cstring>

#include "recording/formats/detail/mat/mat_5.hpp"
#include "recording/formats/detail/mat/mat_73.hpp"
#include "recording/recording.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace decid;

namespace {

constexpr std::size_t header_bytes = 128;

/// Each element of a file of version 5, if it is little endian, in a compressed one.
std::string compressed(std::string_view file) {
  std::string made(file.substr(0, header_bytes));
  for (std::size_t at = header_bytes; at + 8 <= file.size();) {
    std::uint32_t size = 0;
    std::memcpy(&size, file.data() + at + 4, sizeof size);
    const std::string_view element = file.substr(at, 8 + std::size_t{size});
    uLongf length = compressBound(element.size());
    std::string stream(length, '\0');
    REQUIRE_THAT(compress2(reinterpret_cast<Bytef*>(stream.data()), &length,
                           reinterpret_cast<const Bytef*>(element.data()), element.size(), 1) == Z_OK);
    const std::uint32_t tag[]{15, static_cast<std::uint32_t>(length)};
    made.append(reinterpret_cast<const char*>(tag), sizeof tag).append(stream, 0, length);
    at += element.size();
  }
  return made;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::InputFile input("recording.mat");
  const std::string_view bytes = fuzz::to_text(data, size);
  std::vector<recording::MatVariable> variables;
  if (recording::from_bytes(bytes, variables)) REQUIRE_THAT(recording::to_bytes(variables) == bytes);
  const recording::MatVersion version = recording::mat_version(bytes);
  if (version == recording::MatVersion::v73) return 0;
  const auto read = [](std::string_view content) {
    const std::filesystem::path& path = input.write(content);
    fuzz::accepts([&] { recording::read_recording(path, {.column = "1", .rate_hz = 50.0}); });
    for (const char* trials : {"trials", "data", "block", "trial"})
      fuzz::accepts([&] {
        const recording::RecordingOptions options{.trial_column = trials, .trial = "2"};
        recording::list_trials(path, options);
        recording::read_recording(path, options);
      });
  };
  read(bytes);
  if (version == recording::MatVersion::v5) read(compressed(bytes));
  return 0;
}
