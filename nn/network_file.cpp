// A network as a file: see network_file.hpp.
#include "nn/network_file.hpp"

#include <iterator>
#include <optional>
#include <string_view>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/number.hpp"
#include "base/text.hpp"

namespace decid::nn {
namespace {

constexpr std::string_view own_prefix = "layers.";

const std::string& metadata(const TensorFile& file, const char* key, const std::string& where) {
  const auto found = file.metadata.find(key);
  if (found == file.metadata.end())
    throw Error(Code::file_unsupported, where, std::string("has no '") + key + "' in its metadata",
                "give a file that decid wrote of a network");
  return found->second;
}

/// Reads "channels,rows,columns".
std::optional<Shape> shape_from(std::string_view text) {
  const std::size_t first = text.find(','), second = text.rfind(',');
  if (first == second) return std::nullopt;
  const std::optional<int> channels = number_from<int>(text.substr(0, first)),
                           rows = number_from<int>(text.substr(first + 1, second - first - 1)),
                           columns = number_from<int>(text.substr(second + 1));
  if (!channels || !rows || !columns) return std::nullopt;
  return Shape{*channels, *rows, *columns};
}

}  // namespace

std::map<std::string, std::string> network_metadata(const Network<float>& network) {
  const Shape& in = network.input_shape();
  return {{architecture_key, network.architecture()},
          {input_key, format("%d,%d,%d", in.channels, in.rows, in.columns)}};
}

void require_values(const TensorFile& file, Shape input, const std::string& architecture, const std::string& where) {
  const std::size_t needed = parameter_count(input, architecture);
  std::size_t there = 0;
  for (const NamedTensor& t : file.tensors) there += t.values.size();
  if (there >= needed) return;
  for (const std::string& skipped : file.skipped)
    if (skipped.starts_with(own_prefix)) refuse_type(skipped, where);
  throw Error(Code::file_damaged, where,
              format("has %zu values in its tensors where its architecture needs %zu", there, needed),
              "give a model file that was not edited");
}

TensorFile to_tensors(const Network<float>& network) {
  TensorFile file;
  file.metadata = network_metadata(network);
  save_network(network, file);
  return file;
}

Network<float> from_tensors(TensorFile&& file, const std::string& where) {
  if (file.metadata.contains(progress_key))
    throw Error(Code::file_unsupported, where, "is the checkpoint of a fit, not a network",
                "call fit() with it and save the network");
  const std::string& text = metadata(file, input_key, where);
  const std::optional<Shape> input = shape_from(text);
  if (!input)
    throw Error(Code::file_damaged, where, "has the input '" + one_line(text.substr(0, 40)) + "'",
                "write channels,rows,columns");
  const std::string& architecture = metadata(file, architecture_key, where);
  require_values(file, *input, architecture, where);
  Network<float> network(*input, architecture);
  load_network(network, std::move(file), where);
  return network;
}

void add_network(const Network<float>& network, const std::string& prefix, TensorFile& file) {
  TensorFile own;
  save_network(network, own);
  for (NamedTensor& t : own.tensors) t.name = prefix + t.name.substr(own_prefix.size());
  std::move(own.tensors.begin(), own.tensors.end(), std::back_inserter(file.tensors));
}

Network<float> added_network(const std::string& prefix, Network<float> like, const TensorFile& file,
                             const std::string& where) {
  TensorFile own;
  for (const NamedTensor& t : file.tensors)
    if (t.name.starts_with(prefix))
      own.tensors.push_back({std::string(own_prefix) + t.name.substr(prefix.size()), t.shape, t.values});
  load_network(like, std::move(own), where);
  return like;
}

void write_network(const Network<float>& network, const std::string& path) {
  TensorFile file = to_tensors(network);
  file.metadata[content_hash_key] = content_sha256(file);
  write_file(path, to_safetensors(file));
}

Network<float> read_network(const std::string& path) {
  TensorFile file = from_safetensors(read_file(path, max_own_file_bytes), path);
  const auto hash = file.metadata.find(content_hash_key);
  if (hash != file.metadata.end() && hash->second != content_sha256(file))
    throw Error(Code::file_damaged, path, "is damaged: its content is not that of its hash", "give a whole copy");
  return from_tensors(std::move(file), path);
}

bool is_network(const TensorFile& file) {
  return file.metadata.contains(architecture_key) && file.metadata.contains(input_key);
}

}  // namespace decid::nn
