// A model's origin as a JSON value. Not installed.
#pragma once

#include "base/files/json.hpp"
#include "identify/network/origin.hpp"

namespace decid {

/// Returns what to_json() prints (origin.hpp).
Json to_json_object(const Origin& origin);

}  // namespace decid
