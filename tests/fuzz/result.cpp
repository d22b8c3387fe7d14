// Results of decid identify, as decid export controller reads them back.
#include "tests/fuzz/fuzz.hpp"
#include "tools/decid/results/identified.hpp"

using namespace decid;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::InputFile input("result.json");
  const std::filesystem::path& path = input.write(fuzz::to_text(data, size));
  for (const bool force : {false, true})
    fuzz::accepts([&] { tools::identified(path, 1 + static_cast<int>(size % 3), force); });
  return 0;
}
