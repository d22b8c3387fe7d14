// Where truths lie among their posteriors' draws, as a figure.
#pragma once

#include <span>
#include <string>

#include "identify/evaluation/calibration.hpp"
#include "sim/parameters.hpp"

namespace decid::tools {

/// SVG: of each parameter the distribution of the fractions of the draws below the truth, less the uniform one. By
/// chance any line leaves the band of `band` either side, Calibration::band_of_all, in 5% of calibrations at most.
std::string calibration_figure(const sim::ParameterTable& table, std::span<const CalibratedTrial> trials, double band);

}  // namespace decid::tools
