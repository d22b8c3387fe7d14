// What decid identify found, read back from its JSON.
#pragma once

#include <optional>
#include <string>

#include "sim/parameters.hpp"
#include "sim/protocol/experiment.hpp"

namespace decid::tools {

/// Of the controller that is exported.
const sim::ParameterTable& controller_parameters();

/// What the JSON that decid identify wrote says of one recording.
struct Identified {
  sim::Parameters parameters;
  std::optional<sim::Body> body;  ///< whose gains they are; results of earlier versions do not say
  std::string which;              ///< of several recordings, for people
  std::string caution;            ///< why they are to be used with caution; empty if they are not
};

/// Recording number `recording`, from 1, of the file. Throws Error for a file that decid identify did not write, and
/// for values that are not usable, unless `force`.
Identified identified(const std::string& path, int recording, bool force);

}  // namespace decid::tools
