// The journal of a data set that is being made, as it is and with its checksums set right.
#include <cstring>

#include "dataset/npz/journal.hpp"
#include "dataset/npz/zip.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace decid;

namespace {

constexpr std::size_t parameters = 7, magic_bytes = 16, front_bytes = 8, entry_bytes = 40;
constexpr std::size_t trial_bytes = (parameters + 1) * sizeof(double) + 8;

std::uint32_t sum_of(std::string_view bytes) {
  return dataset::crc32(std::as_bytes(std::span(bytes)));
}

std::string mended(std::string bytes) {
  if (bytes.size() < magic_bytes + front_bytes) return bytes;
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + magic_bytes, sizeof length);
  std::size_t at = magic_bytes + front_bytes;
  if (length > bytes.size() - at) return bytes;
  std::uint32_t sum = sum_of(std::string_view(bytes).substr(at, length));
  std::memcpy(bytes.data() + magic_bytes + 4, &sum, sizeof sum);
  for (at += length; at + entry_bytes <= bytes.size();) {
    std::uint32_t trials = 0;
    std::memcpy(&trials, bytes.data() + at + 4, sizeof trials);
    const std::size_t size = entry_bytes + trials * trial_bytes;
    if (size > bytes.size() - at) break;
    std::memset(bytes.data() + at + 36, 0, sizeof sum);
    sum = sum_of(std::string_view(bytes).substr(at, size));
    std::memcpy(bytes.data() + at + 36, &sum, sizeof sum);
    at += size;
  }
  return bytes;
}

void read(std::string_view bytes) {
  static const fuzz::InputFile input("data.npz.journal");
  const std::filesystem::path& path = input.write(bytes);
  fuzz::accepts([&] {
    dataset::Journal journal(path, parameters);
    if (!journal.request()) return;
    int trials = 0;
    while (const auto entry = journal.read(trials)) {
      trials += static_cast<int>(entry->chunk.trials.size());
      journal.pass(*entry);
      if (entry->chunk.trials.empty()) break;
    }
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  read(fuzz::text_of(data, size));
  read(mended(std::string(fuzz::text_of(data, size))));
  return 0;
}
