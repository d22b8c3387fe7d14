// Data sets: zip archives of NumPy arrays, as they are and with the checksums of their stored members set right, since
// a mutation would stop at these.
#include "dataset/npz/npz.hpp"

#include <cstring>

#include "dataset/npz/detail/zip.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace decid;

namespace {

template <class T>
T number_at(const std::string& bytes, std::size_t at) {
  T value{};
  if (at + sizeof value <= bytes.size()) std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// Every entry of the directory whose member lies in the file gets its checksum, here and in the member's header.
std::string mended(std::string bytes) {
  constexpr std::size_t entry_bytes = 46, local_bytes = 30;
  for (std::size_t at = bytes.find("PK\x01\x02"); at != std::string::npos; at = bytes.find("PK\x01\x02", at + 1)) {
    if (at + entry_bytes > bytes.size()) break;
    const std::size_t size = number_at<std::uint32_t>(bytes, at + 20), local = number_at<std::uint32_t>(bytes, at + 42);
    if (local >= bytes.size() || local + local_bytes > bytes.size()) continue;
    const std::size_t begin =
        local + local_bytes + number_at<std::uint16_t>(bytes, local + 26) + number_at<std::uint16_t>(bytes, local + 28);
    if (begin > bytes.size() || size > bytes.size() - begin) continue;
    const std::uint32_t sum = dataset::crc32(std::as_bytes(std::span(bytes.data() + begin, size)));
    std::memcpy(bytes.data() + at + 16, &sum, sizeof sum);
    std::memcpy(bytes.data() + local + 14, &sum, sizeof sum);
  }
  return bytes;
}

void read(std::string_view bytes) {
  static const fuzz::InputFile input("data.npz");
  const std::filesystem::path& path = input.write(bytes);
  fuzz::accepts([&] {
    const dataset::Dataset whole = dataset::read_npz(path);
    const dataset::StoredDataset stored(path);
    REQUIRE_THAT(stored.trials() == whole.trials());
    std::vector<float> sway(static_cast<std::size_t>(whole.samples));
    stored.read(whole.trials() - 1, sway);
    REQUIRE_THAT(std::memcmp(sway.data(), whole.trial(whole.trials() - 1).data(), sway.size() * sizeof(float)) == 0);
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes = fuzz::to_text(data, size);
  read(bytes);
  const std::string right = mended(std::string(bytes));
  if (right != bytes) read(right);
  return 0;
}
