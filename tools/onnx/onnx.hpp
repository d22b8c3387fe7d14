// A model's network as ONNX, the format that other inference engines read: from the image of a trial, as decid image
// writes it, to the network's outputs, which the model's head reads.
// Format: https://github.com/onnx/onnx, onnx.proto, operators of version 13.
#pragma once

#include <string>

#include "identify/network/model.hpp"

namespace decid::tools {

/// Returns the bytes of a file. Input "images" (trials, channels, rows, columns), row scaling applied; output "outputs"
/// (trials, outputs), in float32. Its metadata_props are the metadata of the model file without its log, keys prefixed
/// "decid.".
std::string onnx_bytes(const Model& model);
/// The same of a network alone, with its architecture and input as metadata_props. Throws Error, as the other does, for
/// a layer that a program registered: no operator is known for it.
std::string onnx_bytes(const nn::Network<float>& network);

}  // namespace decid::tools
