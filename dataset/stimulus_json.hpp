// Kinds of stimulus as JSON, one key each in a protocol. Private to dataset.
// Keys: the doc in protocol_json.hpp.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dataset/json_object.hpp"
#include "sim/stimulus.hpp"

namespace decid::dataset {

/// Where a protocol comes from.
struct ProtocolSource {
  std::string where;                              ///< names it in errors
  std::string name = "default";                   ///< of a protocol that says none
  const std::filesystem::path* folder = nullptr;  ///< what its files are relative to; null: it may not name any
  std::vector<std::string>* files = nullptr;      ///< gets the names of the files that were read
};

/// Adds the stimulus to a protocol's object, under its key.
void write_stimulus(const sim::StimulusKind& stimulus, Json& protocol);

/// Reads the stimulus of a protocol's object, if it has one. A measured tilt in a file is brought to sample_rate_hz.
/// Throws Error for several stimuli in one protocol, and for what the file's reading throws.
void read_stimulus(JsonObject& protocol, const ProtocolSource& source, double sample_rate_hz,
                   sim::StimulusKind& stimulus);

}  // namespace decid::dataset
