// The layers there are: each made from the words after its name. Shapes and formulas in the kernels' table.
#pragma once

#include <memory>

#include "nn/layer.hpp"

namespace decid::nn {

/// Cross-correlation with bias; any kernel, stride and zero padding smaller than the kernel.
template <class T>
std::unique_ptr<Layer<T>> make_conv2d(Shape src, Words& words);

/// Batch normalisation of each channel over batch, rows and columns; epsilon 1e-5, running statistics with momentum
/// 0.1, the running variance unbiased. Ioffe and Szegedy, ICML 2015.
template <class T>
std::unique_ptr<Layer<T>> make_batchnorm(Shape src, Words& words);

template <class T>
std::unique_ptr<Layer<T>> make_relu(Shape src, Words& words);

template <class T>
std::unique_ptr<Layer<T>> make_max_pool(Shape src, Words& words);
template <class T>
std::unique_ptr<Layer<T>> make_average_pool(Shape src, Words& words);
template <class T>
std::unique_ptr<Layer<T>> make_global_average_pool(Shape src, Words& words);

/// y = W x + b over all values of a sample.
template <class T>
std::unique_ptr<Layer<T>> make_fully_connected(Shape src, Words& words);

}  // namespace decid::nn
