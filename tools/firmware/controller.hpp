// The DEC controller as C files for a firmware, with parameters that were identified or chosen.
#pragma once

#include <cstdint>
#include <span>

#include "sim/simulate.hpp"
#include "tools/firmware/text.hpp"

namespace decid::tools {

/// Returns FNV-1a over the bits of values, a word at a time: hash_of in runtime/controller.c.
std::uint64_t hash_values(std::span<const double> values);

/// Simulates the self-test's trial, noise-free, with the protocol's body and tilt. Throws Error if the
/// body falls with these parameters before the protocol ends, or if they cannot be simulated.
FirmwareFiles controller_files(const sim::Parameters& parameters, const sim::Protocol& protocol,
                               const std::string& name, const std::string& origin);

}  // namespace decid::tools
