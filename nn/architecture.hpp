// Makes layers from an architecture's text, one layer per line.
#pragma once

#include <string>
#include <vector>

#include "nn/layers/layer.hpp"

namespace decid::nn {

/// Returns the layers that the lines of an architecture describe, for inputs of shape `src`; they have no values yet:
///   conv CHANNELS ROWSxCOLUMNS [stride RxC] [pad RxC] [groups N] [dilation RxC]    fc OUTPUTS    batchnorm layernorm
///   relu    leakyrelu [SLOPE]    gelu    tanh    sigmoid    dropout RATE    globalavgpool    statspool
///   maxpool RxC [stride RxC] [pad RxC]    avgpool RxC [stride RxC] [pad RxC]
///   residual {, the lines of a block, }: their output plus their input
///   concat {, the lines of a block, }: their input's channels, then their output's
/// and those that a program registers (nn/operation.hpp).
/// A batchnorm line and the relu and pool lines behind it are fused into one layer. Throws Error, naming the line, for
/// an unknown word or a geometry that leaves no output.
std::vector<LayerKind> parse_layers(Shape src, const std::vector<std::string>& lines);
/// Makes these layers, with the memory of their values.
template <class T>
std::vector<Layer<T>> make_layers(Shape src, const std::vector<std::string>& lines);

}  // namespace decid::nn
