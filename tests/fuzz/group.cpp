// Tables of groups of recordings.
#include "tests/fuzz/fuzz.hpp"
#include "tools/decid/group_file.hpp"

using namespace decid;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::InputFile input("groups.csv");
  static const std::vector<RecordingSource> recordings{"patients/a.csv", "controls/a.csv", "b.csv", "../c d.csv"};
  const std::filesystem::path& path = input.write(fuzz::to_text(data, size));
  fuzz::accepts([&] { REQUIRE_THAT(tools::read_group_table(path, recordings).members.size() == recordings.size()); });
  return 0;
}
