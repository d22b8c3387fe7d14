// The layers there are: each made from the words of its line. Shapes and formulas in the kernels' table.
#pragma once

#include <memory>
#include <optional>

#include "nn/layer.hpp"
#include "nn/pooling.hpp"

namespace decid::nn {

/// Cross-correlation with bias; any kernel, stride and zero padding smaller than the kernel.
template <class T>
std::unique_ptr<Layer<T>> make_conv2d(Shape src, Words& words);

/// Batch normalisation of each channel over batch, rows and columns, then, if asked for, ReLU and a pool whose windows
/// do not overlap. epsilon 1e-5, running statistics with momentum 0.1, the running variance unbiased. Ioffe and
/// Szegedy, ICML 2015.
template <class T>
std::unique_ptr<Layer<T>> make_batchnorm(Shape src, bool relu, const std::optional<Pool>& pool);

template <class T>
std::unique_ptr<Layer<T>> make_relu(Shape src);

template <class T>
std::unique_ptr<Layer<T>> make_pool(const Pool& pool);

/// y = W x + b over all values of a sample.
template <class T>
std::unique_ptr<Layer<T>> make_fully_connected(Shape src, Words& words);

}  // namespace decid::nn
