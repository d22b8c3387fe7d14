// Reads a file that holds only a network: see network_alone.hpp.
#include "tools/decid/network_alone.hpp"

#include "base/error.hpp"
#include "base/files/file.hpp"

namespace decid::tools {
namespace {

/// Returns nothing if the file is not safetensors.
std::optional<nn::TensorFile> tensors_of(const std::string& path) {
  try {
    return nn::from_safetensors(read_file(path, max_own_file_bytes), path);
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace

std::optional<NetworkAlone> network_alone(const std::string& path) {
  if (path.empty()) return std::nullopt;
  const std::optional<nn::TensorFile> file = tensors_of(path);
  if (!file || !nn::is_network(*file)) return std::nullopt;
  return NetworkAlone{nn::read_network(path), file->skipped};
}

}  // namespace decid::tools
