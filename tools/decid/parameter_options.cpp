// Options for the parameters of controllers: see parameter_options.hpp.
#include "tools/decid/parameter_options.hpp"

#include <algorithm>

#include "base/error.hpp"

namespace decid::tools {

void ParameterOptions::add(const Command& command, const Help& help) {
  for (const sim::BodyModel* model : sim::body_models()) {
    for (std::size_t i = 0; i < model->parameters.size(); ++i) {
      const std::string& name = model->parameters[i].option;
      if (model->family.terms.empty() || values_.contains(name)) continue;
      const std::string text = help(*model, i);
      if (!text.empty()) command.add_option("--" + name, values_[name], text).shown_as("FLOAT");
    }
  }
}

GivenParameters ParameterOptions::of(const sim::BodyModel& model) const {
  for (const auto& [option, value] : values_) {
    if (!value || std::ranges::count(model.parameters, option, &sim::ParameterInfo::option) > 0) continue;
    std::string names;
    for (const sim::ParameterInfo& info : model.parameters)
      if (values_.contains(info.option)) names += (names.empty() ? "--" : ", --") + info.option;
    throw Error(Code::setting_unknown, "--" + option, "is not a parameter of the controller " + model.name,
                "its parameters here are " + names);
  }
  GivenParameters given;
  for (const sim::ParameterInfo& info : model.parameters) {
    const auto found = values_.find(info.option);
    given.push_back(found == values_.end() ? std::nullopt : found->second);
  }
  return given;
}

sim::Parameters filled(sim::Parameters parameters, const GivenParameters& given) {
  for (std::size_t i = 0; i < given.size(); ++i) parameters[i] = given[i].value_or(parameters[i]);
  return parameters;
}

}  // namespace decid::tools
