// The options --range, --prior and --fix: priors of a controller's parameters.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "posterior/density/priors.hpp"
#include "sim/protocol/protocol.hpp"
#include "tools/decid/command.hpp"

namespace decid::tools {

/// An option's text for a parameter: NAME=VALUE, or NAME/mgh=VALUE over the body's m g h.
struct NamedText {
  explicit NamedText(const std::string& text);
  posterior::PriorName name;
  std::optional<std::string> value;  ///< empty: the text has no =
};

/// Texts of --range, --prior and --fix: NAME=LOW,HIGH, NAME=MEAN,SD and NAME=VALUE. NAME/mgh has values over m g h.
struct PriorTexts {
  std::vector<std::string> ranges, normals, fixed;
};

void add_prior_options(const Command& command, PriorTexts& priors);

/// Returns the priors that the texts give for the parameters of the protocol's controller. Ignores parameters that only
/// others of `controllers`, those of the call, have. Priors over m g h remain so, because recordings may have other
/// bodies. has_sheet: a study's sheet gives bodies, so that a normal prior is checked later if only one of it and its
/// range is over m g h. Throws Error naming the option.
std::vector<posterior::ParameterPrior> parameter_priors(const PriorTexts& texts, const sim::Protocol& protocol,
                                                        const std::vector<const sim::BodyModel*>& controllers,
                                                        bool has_sheet = false);

}  // namespace decid::tools
