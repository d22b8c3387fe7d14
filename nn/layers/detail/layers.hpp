// The layers, one file each, as architecture.cpp finds them: parsers of their lines, whose first word was taken. Not
// installed.
#pragma once

#include "nn/layers/layer.hpp"
#include "nn/operation.hpp"

namespace decid::nn {

LayerKind parse_conv(Shape src, Words& words);
LayerKind parse_fully_connected(Shape src, Words& words);
LayerKind parse_batchnorm(Shape src, Words& words);
/// Returns true if `before` is a BatchNorm that `next`, the layer of the next line, became a part of.
bool fuse_with_batchnorm(LayerKind& before, const LayerKind& next);
LayerKind parse_relu(Shape src, Words& words);
LayerKind parse_statistics_pool(Shape src, Words& words);
LayerKind parse_pool(Shape src, Words& words);
LayerKind parse_block(Shape src, Words& words);
/// Makes the end of a block from its beginning and its last output.
LayerKind end_block(const Branch& branch, Shape src, const Words& words);

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
