// Networks' architectures as text, for an image of the usual size and for a series.
#include "nn/architecture.hpp"

#include <sstream>

#include "tests/fuzz/fuzz.hpp"

using namespace decid;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t max_lines = 100;
  std::istringstream text{std::string(fuzz::to_text(data, size))};
  std::vector<std::string> lines;
  for (std::string line; lines.size() < max_lines && std::getline(text, line);) lines.push_back(line);
  for (const nn::Shape shape : {nn::Shape{2, 110, 110}, nn::Shape{6, 605, 1}})
    fuzz::accepts([&] { nn::make_layers<float>(shape, lines); });
  return 0;
}
