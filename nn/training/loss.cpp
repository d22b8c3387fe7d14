// Mean squared error: see loss.hpp.
#include "nn/training/loss.hpp"

#include <array>
#include <string>

#include "base/error.hpp"
#include "nn/kernels/kernels.hpp"

namespace decid::nn {
namespace {

template <class T>
void check_sizes(const TensorView<const T>& output, std::span<const T> targets, const TensorView<T>& diff,
                 std::size_t sums, std::size_t needed) {
  const int outputs = output.shape().channels, samples = output.batch();
  if (output.shape() != Shape{outputs, 1, 1} || diff.shape() != output.shape() || diff.batch() != samples)
    throw Error(Code::size_mismatch, "mean squared error", "of tensors that are not both (outputs, 1, 1) of one batch",
                "give a fully connected layer's output and a derivative of its shape");
  if (sums < needed || targets.size() < static_cast<std::size_t>(samples) * static_cast<std::size_t>(outputs))
    throw Error(Code::size_mismatch, "mean squared error",
                std::to_string(targets.size()) + " targets and " + std::to_string(sums) + " sums for a batch of " +
                    std::to_string(samples) + " with " + std::to_string(outputs) + " outputs",
                "give a target for each output of each sample, a sum for each output");
}

/// The squared errors of one output of a block; its derivatives are written.
template <class T>
double compute_errors(const TensorView<const T>& output, std::span<const T> targets, T factor, int block, int o,
                      const TensorView<T>& diff) {
  const auto width = static_cast<std::size_t>(output.shape().channels);
  std::array<double, lanes> squared{};
  for (int l = 0; l < lanes; ++l) {
    const int sample = block * lanes + l;
    T gradient = T(0);
    if (sample < output.batch()) {
      const T error =
          output.row(block, o, 0)[l] - targets[static_cast<std::size_t>(sample) * width + static_cast<std::size_t>(o)];
      squared[static_cast<std::size_t>(l)] = static_cast<double>(error) * static_cast<double>(error);
      gradient = factor * error;
    }
    diff.row(block, o, 0)[l] = gradient;
  }
  tree_sum(squared.data(), lanes, 1, 1);
  return squared[0];
}

/// d MSE / d error, of 1.
template <class T>
T slope_of(int batch, int outputs) {
  return T(2) / static_cast<T>(static_cast<long long>(batch) * outputs);
}

}  // namespace

template <class T>
void squared_errors(const std::type_identity_t<TensorView<const T>>& output,
                    std::type_identity_t<std::span<const T>> targets, int batch, std::span<double> parts,
                    const TensorView<T>& diff) {
  const int outputs = output.shape().channels;
  check_sizes(output, targets, diff, parts.size(),
              static_cast<std::size_t>(output.blocks()) * static_cast<std::size_t>(outputs));
  const T slope = slope_of<T>(batch, outputs);
  std::size_t i = 0;
  for (int block = 0; block < output.blocks(); ++block)
    for (int o = 0; o < outputs; ++o) parts[i++] = compute_errors(output, targets, slope, block, o, diff);
}

template void squared_errors<float>(const TensorView<const float>&, std::span<const float>, int, std::span<double>,
                                    const TensorView<float>&);
template void squared_errors<double>(const TensorView<const double>&, std::span<const double>, int, std::span<double>,
                                     const TensorView<double>&);

}  // namespace decid::nn
