// A network's layers as C: the runtime's settings and tables.
#pragma once

#include <string>

#include "tools/firmware/plan.hpp"

namespace decid::tools {

/// Returns true if a layer of the plan is of this kind.
bool has_kind(const FirmwarePlan& plan, FirmwareLayer::Kind kind);
/// Returns true if a layer of the plan needs the exponential function.
bool uses_exponential(const FirmwarePlan& plan);
/// Returns the preprocessor's settings for the kinds of layers that the plan has.
std::string layer_settings(const FirmwarePlan& plan);
/// Returns the tables of weights, maps and layers.
std::string layer_tables(const FirmwarePlan& plan);

}  // namespace decid::tools
