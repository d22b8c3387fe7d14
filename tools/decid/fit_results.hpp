// What `decid fit` reports on recordings: what `decid identify` does, and the fit's own figures.
#pragma once

#include <string>

#include "identify/fit/fit_recordings.hpp"

namespace decid::tools {

/// What identify prints, and for each recording the fit's own figures: standard errors, cost, simulations, seconds.
std::string fits_json(const std::string& model, const FittedRecordings& all);
std::string fits_text(const FittedRecordings& all);

}  // namespace decid::tools
