// What the pages of `decid identify` and `decid fit` say of a recording alike.
#pragma once

#include <span>

#include "base/json.hpp"
#include "identify/recordings.hpp"

namespace decid::tools {

/// parameters_json() of its estimate, with "description", "low" and "high" of the range.
Json described_parameters(const Identification& recording, const sim::Protocol& protocol);
/// Its measured tilt: "column", "delay_s", "correlation", "gain"; null if there is none.
Json tilt_to_json(const Identification& recording);

/// The power of ten that makes whole numbers of values whose widest excursion this is: three to four digits of it.
double whole_per_unit(double widest);
/// values * per_unit, rounded; null where they are not finite.
Json whole_numbers(std::span<const double> values, double per_unit);

}  // namespace decid::tools
