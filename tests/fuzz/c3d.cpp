// C3D files of every processor: each column of the table that they make, and a recording with what gaps it has filled.
#include "recording/formats/detail/c3d.hpp"

#include "recording/recording.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace decid;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::InputFile input("recording.c3d");
  const std::string_view bytes = fuzz::to_text(data, size);
  fuzz::accepts([&] {
    const recording::C3dTable table(std::string(bytes), "recording.c3d");
    for (int column = 0; column < table.columns() && column < 100; ++column)
      fuzz::accepts(
          [&] { REQUIRE_THAT(table.numbers(column, recording::Missing::kept).size() == table.rows(column)); });
  });
  const std::filesystem::path& path = input.write(bytes);
  fuzz::accepts([&] {
    recording::read_recording(path, {.column = "1", .fill_gaps_s = 1.0, .com_height_m = 0.9, .metres_per_unit = 1e-3});
  });
  return 0;
}
