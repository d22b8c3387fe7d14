// Reads a file that holds only a network, as nn::write_network makes it, where a command would take a model.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "nn/network_file.hpp"

namespace decid::tools {

struct NetworkAlone {
  nn::Network<float> network;
  std::vector<std::string> skipped;  ///< tensors that no layer has, with their types
};

/// Returns nothing for an empty path and for a file that does not hold only a network; the model reader then reports
/// the error. Throws Error for a damaged network.
std::optional<NetworkAlone> network_alone(const std::string& path);

}  // namespace decid::tools
