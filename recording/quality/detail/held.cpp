// Values that are held: see held.hpp.
#include "recording/quality/detail/held.hpp"

#include <numeric>

namespace decid::recording {

std::vector<double> Held::values_of(std::span<const double> sway) const {
  std::vector<double> values;
  if (first > 0 && !sway.empty()) values.push_back(sway.front());
  for (std::size_t k = first; k < sway.size(); k += samples) values.push_back(sway[k]);
  return values;
}

Held find_held(std::span<const double> sway) {
  constexpr std::size_t fewest = 20;
  std::size_t changes = 0, first = 0, last = 0, common = 0;
  for (std::size_t k = 1; k < sway.size(); ++k) {
    if (sway[k] == sway[k - 1]) continue;
    if (changes++ == 0)
      first = k;
    else if (common = std::gcd(common, k - last); common == 1)
      return {};
    last = k;
  }
  if (changes < fewest || common < 2 || 2 * changes * common < sway.size()) return {};
  return {common, first % common};
}

}  // namespace decid::recording
