// Stochastic gradient descent: see sgd.hpp.
#include "nn/training/sgd.hpp"

#include "nn/training/sharing.hpp"

namespace decid::nn {

template <class T>
void sgd_step(Parameter<T>& parameter, std::span<const T> gradient, std::span<T> velocity, double learning_rate,
              const SgdSettings& settings) {
  const T decay = static_cast<T>(parameter.decays ? settings.weight_decay : 0.0);
  for_each_group(1, static_cast<int>(parameter.value.size()), value_group, [&](int, int first, int last) {
    kernels<T>().sgd_step(static_cast<std::size_t>(last - first), static_cast<T>(learning_rate),
                          static_cast<T>(settings.momentum), decay, gradient.data() + first, velocity.data() + first,
                          parameter.value.data() + first);
  });
}

template void sgd_step(Parameter<float>&, std::span<const float>, std::span<float>, double, const SgdSettings&);
template void sgd_step(Parameter<double>&, std::span<const double>, std::span<double>, double, const SgdSettings&);

}  // namespace decid::nn
