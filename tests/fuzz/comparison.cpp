// Comparisons of methods, as decid study reads them back.
#include "base/files/json_object.hpp"
#include "sim/protocol/protocol.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tools/report/comparison_page.hpp"

using namespace decid;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::InputFile input("comparison.json");
  static const sim::Protocol protocol = sim::default_protocol();
  const std::filesystem::path& path = input.write(fuzz::to_text(data, size));
  fuzz::accepts([&] {
    const ComparisonFigures comparison = tools::read_comparison(path, protocol);
    tools::comparison_text(comparison);
    print_json(tools::comparison_json(comparison));
  });
  return 0;
}
