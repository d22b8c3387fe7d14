// What `decid fit` says of recordings: what `decid identify` says, and the fit's own figures.
#pragma once

#include <string>
#include <vector>

#include "identify/fit/fit_recordings.hpp"

namespace decid::tools {

/// What identify prints, and for each recording the fit's own figures: standard errors, cost, simulations, seconds.
std::string fits_json(const std::string& model, const std::vector<Fitted>& all);
std::string fits_text(const std::vector<Fitted>& all);

}  // namespace decid::tools
