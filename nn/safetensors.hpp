// Weights on disk: the safetensors format (8 bytes of header length, a JSON header, raw little-endian values), which
// PyTorch, JAX, NumPy and others read. float32 is written; float32, float16 and bfloat16 are read, as float32.
// Format: https://github.com/huggingface/safetensors, README, section "Format".
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "nn/network.hpp"

namespace decid::nn {

struct NamedTensor {
  std::string name;
  std::vector<long long> shape;
  std::vector<float> values;
};

struct TensorFile {
  std::map<std::string, std::string> metadata;
  std::vector<NamedTensor> tensors;
  std::vector<std::string> skipped;  ///< names with types of tensors that are not floating-point numbers of 16 or 32
                                     ///< bits: "bn1.num_batches_tracked (I64)"

  /// Throws Error (naming `where`) if there is no such tensor or it has not `count` values.
  const NamedTensor& find(const std::string& name, std::size_t count, const std::string& where) const;
  NamedTensor& find(const std::string& name, std::size_t count, const std::string& where) {
    return const_cast<NamedTensor&>(std::as_const(*this).find(name, count, where));
  }
};

/// Throws Error (naming `where`) for a layer's tensor that was skipped for its type; skipped: of TensorFile.
[[noreturn]] void refuse_type(const std::string& skipped, const std::string& where);

/// Finds the tensors of a file by name, for many of them. The file must outlive it, and keep its tensors.
class TensorIndex {
 public:
  explicit TensorIndex(const TensorFile& file);
  /// As TensorFile::find().
  const NamedTensor& find(const std::string& name, std::size_t count, const std::string& where) const;

 private:
  const TensorFile& file_;
  std::unordered_map<std::string_view, std::size_t> places_;
};

/// The key of the metadata that holds content_sha256.
inline constexpr const char* content_hash_key = "sha256";
/// Returns the SHA-256 over a file's contents, for any layout of the file: of each entry of the metadata except the
/// hash itself, in order of the keys, key, zero byte, value, zero byte; then of each tensor, in order of the names,
/// name, zero byte, shape ("4,3"), zero byte, values (little-endian). Names and keys in order of their bytes.
std::string content_sha256(const TensorFile& file);

/// Returns the bytes of a file; equal contents give equal bytes. The values start at a multiple of 8 bytes.
std::string to_safetensors(const TensorFile& file);

/// Throws Error (naming `where`) for anything that the format does not allow: truncated or trailing bytes, bad JSON,
/// overlapping or missing ranges, shapes that do not fit, names given twice, an unknown type.
TensorFile from_safetensors(std::string_view bytes, const std::string& where);

/// Adds all parameters and running statistics as "layers.<line>.<name>"; with `momentum_buffers`, those of sgd() for a
/// checkpoint (OptimiserState::memory), these as "momentum.<line>.<name>". Throws Error, and adds nothing, for values
/// that load_network refuses: not finite, or a negative variance.
void save_network(const Network<float>& network, TensorFile& file,
                  const std::vector<std::vector<float>>* momentum_buffers = nullptr);
/// Copies the tensors of `file` into the network, whose values stay where they are in memory, and moves those of the
/// momentum buffers, unless null, into them. Throws Error, and changes nothing, if a tensor is missing, of another
/// shape (axes of length 1 do not count), or not finite, or a variance is negative.
void load_network(Network<float>& network, TensorFile&& file, const std::string& where,
                  std::vector<std::vector<float>>* momentum_buffers = nullptr);

}  // namespace decid::nn
