// Reads the results of decid identify back from its JSON.
#pragma once

#include <optional>
#include <string>

#include "sim/parameters.hpp"
#include "sim/protocol/experiment.hpp"

namespace decid::tools {

/// The result of one recording in the JSON that decid identify wrote.
struct Identified {
  const sim::BodyModel* controller = &sim::single_pendulum();
  sim::Parameters parameters;
  std::optional<sim::Body>
      body;             ///< the body of the gains; missing if nobody gave one, and in results of earlier versions
  std::string which;    ///< the name of the recording among several, for people
  std::string caution;  ///< the reason for caution; empty if there is none
};

/// Reads recording number `recording`, from 1, of the file. Throws Error for a file that decid identify did not write.
/// Throws Error also for values that are not usable, unless `force`.
Identified identified(const std::string& path, int recording, bool force);

}  // namespace decid::tools
