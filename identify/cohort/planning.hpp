// The uncertainty of one recording of a planned study, for cohort/power.hpp.
#pragma once

#include <cstdint>

#include "identify/network/model.hpp"

namespace decid::cohort {

/// Returns the standard deviation that the model's network gives each parameter of one recording, SI units, its prior
/// divided out: the median over `trials` simulated recordings of persons N(at, person_sd^2) within the ranges, with the
/// recording artefacts of the protocol. Throws Error for a model without distributions, no trial, a mean outside of the
/// ranges, and controllers that do not stand.
sim::Parameters measurement_sd(const Model& model, const sim::Protocol& protocol, const sim::Parameters& at,
                               const sim::Parameters& person_sd, int trials, std::uint64_t seed);

}  // namespace decid::cohort
