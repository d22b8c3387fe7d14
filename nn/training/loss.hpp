// Mean squared error over a batch, with its gradient.
#pragma once

#include <span>
#include <type_traits>

#include "nn/tensor.hpp"

namespace decid::nn {

/// The errors of a batch, or of one rank's blocks of a batch of `batch` samples in all: parts[block * outputs + o] =
/// sum over the block's samples of (output - target)^2 of output o, in double, a lane tree. targets, output, diff as
/// below. Throws Error for too few targets or parts, and for tensors of other shapes.
template <class T>
void squared_errors(const std::type_identity_t<TensorView<const T>>& output,
                    std::type_identity_t<std::span<const T>> targets, int batch, std::span<double> parts,
                    const TensorView<T>& diff);

/// Loss of a batch: squares[o] = sum over samples of (output - target)^2 of output o, in double: a lane tree a block,
/// then the blocks in order, so the bits depend on the batch alone. targets: batch x outputs, row-major. output: a
/// tensor of shape (outputs, 1, 1). diff, of the same shape, gets d MSE / d output = 2 (output - target) / (batch *
/// outputs), with MSE = sum(squares) / (batch * outputs); lanes without a sample get 0.
/// Throws Error for too few targets or squares, and for tensors of other shapes.
template <class T>
void mean_squared_error(const std::type_identity_t<TensorView<const T>>& output,
                        std::type_identity_t<std::span<const T>> targets, std::span<double> squares,
                        const TensorView<T>& diff);

}  // namespace decid::nn
