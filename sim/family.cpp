// Coefficients of the family: see family.hpp.
#include "sim/family.hpp"

#include <algorithm>
#include <cmath>

namespace decid::sim {

Coefficients Family::coefficients(const Parameters& parameters) const {
  Coefficients all = constant;
  for (const Term& term : terms)
    all[term.coefficient] = std::fma(term.factor, parameters[term.parameter], all[term.coefficient]);
  return all;
}

bool Family::varies(Coefficient coefficient, double value) const {
  return constant[coefficient] != value ||
         std::ranges::any_of(terms, [&](const Term& term) { return term.coefficient == coefficient; });
}

bool Family::has_unit_gains() const {
  return !varies(Coefficient::position, 1.0) && !varies(Coefficient::tilt, 1.0) && !varies(Coefficient::gravity, 1.0) &&
         !varies(Coefficient::slow, 0.0) && !varies(Coefficient::torque, 0.0);
}

std::optional<std::size_t> Family::find_parameter(Coefficient coefficient) const {
  std::optional<std::size_t> found;
  for (const Term& term : terms) {
    if (term.coefficient != coefficient) continue;
    if (found && *found != term.parameter) return {};
    found = term.parameter;
  }
  return found;
}

Parameters Family::without_noise(Parameters parameters) const {
  for (const Term& term : terms) {
    if (term.coefficient == Coefficient::nv) parameters[term.parameter] = 0.0;
  }
  return parameters;
}

}  // namespace decid::sim
