// A network as a file: its tensors (nn/safetensors.hpp), its architecture and the shape of its input.
#pragma once

#include <map>
#include <string>

#include "nn/safetensors.hpp"

namespace decid::nn {

/// The keys of the metadata that hold Network::architecture() and "channels,rows,columns".
inline constexpr const char* architecture_key = "architecture";
inline constexpr const char* input_key = "input";
/// The key that only a fit's checkpoint has (FitOptions::checkpoint).
inline constexpr const char* progress_key = "progress";

/// Returns these metadata of a network.
std::map<std::string, std::string> network_metadata(const Network<float>& network);
/// Throws Error, naming `where`, if the file's tensors have fewer values than the parameters of this architecture. To
/// be called before the network is made: a text of a few bytes can describe gigabytes.
void require_values(const TensorFile& file, Shape input, const std::string& architecture, const std::string& where);

/// Returns a file's content. Equal networks give equal files.
TensorFile to_tensors(const Network<float>& network);
/// Makes the network of such a file; tensors that belong to no layer are skipped. Throws Error, naming `where`, if
/// metadata or tensors are missing or not those of a network, and for the checkpoint of a fit, whose weights are the
/// last step's and not those that the fit will keep.
Network<float> from_tensors(TensorFile&& file, const std::string& where);

/// Adds another network of the same architecture to a checkpoint; its tensors begin with `prefix` ("average.") instead
/// of "layers.".
void add_network(const Network<float>& network, const std::string& prefix, TensorFile& file);
/// Returns the network that add_network() added, of the architecture of `like`. Throws Error as load_network().
Network<float> added_network(const std::string& prefix, Network<float> like, const TensorFile& file,
                             const std::string& where);

/// Throws Error if the file cannot be written.
void write_network(const Network<float>& network, const std::string& path);
/// Throws Error if the file cannot be read, was damaged, or holds no network; also for the checkpoint of a fit.
Network<float> read_network(const std::string& path);
/// Returns true if the metadata describe only a network. Models of decid have an image instead of an input.
bool is_network(const TensorFile& file);

}  // namespace decid::nn
