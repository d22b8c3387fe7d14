// Comparisons of methods, as decid study reads them back.
#include "base/files/json_object.hpp"
#include "sim/protocol/protocol.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tools/report/comparison_page.hpp"

using namespace decid;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::InputFile input("comparison.json");
  static const sim::ParameterTable ranges = sim::default_protocol().ranges();
  const std::filesystem::path& path = input.write(fuzz::text_of(data, size));
  fuzz::accepts([&] {
    const Json comparison = tools::read_comparison(path, ranges);
    tools::comparison_text(comparison, ranges);
    print_json(comparison);
  });
  return 0;
}
