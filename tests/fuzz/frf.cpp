// Tables of frequency responses.
#include "posterior/frf/table.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace decid;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::InputFile input("frf.csv");
  const std::filesystem::path& path = input.write(fuzz::to_text(data, size));
  fuzz::accepts([&] { REQUIRE_THAT(frf::read_table(path).rows.size() >= frf::min_table_rows); });
  return 0;
}
