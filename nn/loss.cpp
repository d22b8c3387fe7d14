// Mean squared error: see loss.hpp.
#include "nn/loss.hpp"

#include <array>
#include <string>

#include "base/error.hpp"
#include "nn/kernels/kernels.hpp"

namespace decid::nn {

template <class T>
void mean_squared_error(const std::type_identity_t<TensorView<const T>>& output,
                        std::type_identity_t<std::span<const T>> targets, std::span<double> squares,
                        const TensorView<T>& diff) {
  const int outputs = output.shape().channels, batch = output.batch();
  const auto values = static_cast<std::size_t>(batch) * static_cast<std::size_t>(outputs);
  if (output.shape() != Shape{outputs, 1, 1} || diff.shape() != output.shape() || diff.batch() != batch)
    throw Error("mean squared error", "of tensors that are not both (outputs, 1, 1) of one batch",
                "give a fully connected layer's output and a derivative of its shape");
  if (targets.size() < values || squares.size() < static_cast<std::size_t>(outputs))
    throw Error("mean squared error",
                std::to_string(targets.size()) + " targets and " + std::to_string(squares.size()) +
                    " sums for a batch of " + std::to_string(batch) + " with " + std::to_string(outputs) + " outputs",
                "give a target for each output of each sample, a sum for each output");
  const T factor = T(2) / static_cast<T>(static_cast<long long>(batch) * outputs);
  for (int o = 0; o < outputs; ++o) {
    double sum = 0;
    for (int block = 0; block < output.blocks(); ++block) {
      std::array<double, lanes> squared{};
      for (int l = 0; l < lanes; ++l) {
        const int sample = block * lanes + l;
        T gradient = T(0);
        if (sample < batch) {
          const T error = output.row(block, o, 0)[l] -
                          targets[static_cast<std::size_t>(sample) * static_cast<std::size_t>(outputs) +
                                  static_cast<std::size_t>(o)];
          squared[static_cast<std::size_t>(l)] = static_cast<double>(error) * static_cast<double>(error);
          gradient = factor * error;
        }
        diff.row(block, o, 0)[l] = gradient;
      }
      tree_sum(squared.data(), lanes, 1, 1);
      sum += squared[0];
    }
    squares[static_cast<std::size_t>(o)] = sum;
  }
}

template void mean_squared_error<float>(const TensorView<const float>&, std::span<const float>, std::span<double>,
                                        const TensorView<float>&);
template void mean_squared_error<double>(const TensorView<const double>&, std::span<const double>, std::span<double>,
                                         const TensorView<double>&);

}  // namespace decid::nn
