// The layers that are one file each (nn/operation.hpp), as architecture.cpp finds them. Not installed.
#pragma once

#include "nn/layers/layer.hpp"
#include "nn/operation.hpp"

namespace decid::nn {

OperationPointer parse_leaky_relu(Shape src, Words& words);
OperationPointer parse_tanh(Shape src, Words& words);
OperationPointer parse_sigmoid(Shape src, Words& words);
OperationPointer parse_gelu(Shape src, Words& words);
OperationPointer parse_layernorm(Shape src, Words& words);
OperationPointer parse_dropout(Shape src, Words& words);
OperationPointer padded_pool(const Pool& pool, int pad_rows, int pad_columns);
/// `shape` has the kernel without dilation, and all groups' channels.
OperationPointer grouped_conv(const Conv2dShape& shape, int groups, int dilation_rows, int dilation_columns);

}  // namespace decid::nn
