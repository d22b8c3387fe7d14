// Moving averages of weights: see average.hpp.
#include "nn/training/average.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "base/text.hpp"
#include "nn/training/sharing.hpp"

namespace decid::nn {
namespace {

void move_towards(std::vector<float>& average, const std::vector<float>& value, float rest) {
  for_each_group(1, static_cast<int>(value.size()), value_group, [&](int, int first, int last) {
    for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(last); ++i)
      average[i] += rest * (value[i] - average[i]);
  });
}

}  // namespace

void move_average(Network<float>& average, const Network<float>& network, double decay, long long step) {
  if (!(decay > 0 && decay < 1))
    throw Error(Code::setting_out_of_range, "average", format("has a decay of %g", decay),
                "give a number between 0 and 1, for example 0.999");
  const auto t = static_cast<double>(step);
  const auto rest = static_cast<float>(1 - std::min(decay, (1 + t) / (10 + t)));
  for (std::size_t i = 0; i < network.layers().size(); ++i) {
    const Layer<float>& from = network.layers()[i];
    Layer<float>& to = average.layers()[i];
    for (std::size_t k = 0; k < from.parameters().size(); ++k)
      move_towards(to.parameters()[k].value, from.parameters()[k].value, rest);
    for (std::size_t k = 0; k < from.statistics().size(); ++k)
      move_towards(to.statistics()[k].value, from.statistics()[k].value, rest);
  }
}

}  // namespace decid::nn
