// The settings of an image as a JSON value. Not installed.
#pragma once

#include "base/files/json.hpp"
#include "dataset/image/image.hpp"

namespace decid::dataset {

/// Returns what to_json() prints (image.hpp).
Json to_json_object(const ImageSettings& settings);

}  // namespace decid::dataset
