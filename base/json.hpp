// The type of JSON values, by name only; json_object.hpp reads and prints them.
// Not installed.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace decid {

/// Keeps the keys in the order in which they were written.
using Json = nlohmann::ordered_json;

}  // namespace decid
