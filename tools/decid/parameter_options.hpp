// Options for the parameters of controllers: one for each name, because a command line is declared before its
// controller is known.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim/body_model.hpp"
#include "tools/decid/options.hpp"

namespace decid::tools {

/// Values given for a controller's parameters, in the order of its table.
using GivenParameters = std::vector<std::optional<double>>;

class ParameterOptions {
 public:
  /// Returns the option's help; an empty text: no option. `model`: the first controller that has the parameter.
  using Help = std::function<std::string(const sim::BodyModel& model, std::size_t parameter)>;

  /// Adds an option for each parameter of all controllers that have a name. This object must live until the program has
  /// been parsed.
  void add(const Command& command, const Help& help);
  /// Returns what was given. Throws Error for an option of other controllers.
  GivenParameters of(const sim::BodyModel& model) const;

 private:
  std::map<std::string, std::optional<double>> values_;  // by option
};

/// Replaces the values that were given.
sim::Parameters filled(sim::Parameters parameters, const GivenParameters& given);

}  // namespace decid::tools
