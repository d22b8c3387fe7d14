// The options --range, --prior and --fix: see prior_texts.hpp.
#include "tools/decid/prior_texts.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/number.hpp"
#include "identify/compared_controllers.hpp"
#include "identify/study/joint_groups.hpp"

namespace decid::tools {
namespace {

/// Reads "NAME=NUMBER" or "NAME/mgh=NUMBER,NUMBER", an option's text for a parameter of the table.
struct NamedNumbers {
  NamedNumbers(const std::string& text, std::size_t count, const char* option, const char* form,
               const sim::ParameterTable& table) {
    const auto fail = [&](const std::string& problem) {
      throw Error(Code::setting_malformed, option, problem, std::string("give ") + form);
    };
    const NamedText named(text);
    if (!named.value) fail("'" + text + "' is not " + form);
    name = named.name.parameter;
    over_mgh = named.name.over_mgh;
    for (std::size_t begin = 0; begin <= named.value->size();) {
      const std::size_t end = std::min(named.value->find(',', begin), named.value->size());
      const std::string number = named.value->substr(begin, end - begin);
      numbers.push_back(number_from<double>(number).value_or(NAN));
      if (!std::isfinite(numbers.back())) fail("'" + number + "' is not a number");
      begin = end + 1;
    }
    if (numbers.size() != count) fail("'" + text + "' is not " + form);
    require_parameter(name, option, table);
  }
  std::string name;
  bool over_mgh = false;
  std::vector<double> numbers;
};

/// Throws Error naming the option for a prior that the protocol's body cannot have. is_over_mgh: the option's value is
/// over m g h.
void check_option(const posterior::ParameterPrior& prior, const char* option, bool is_over_mgh,
                  const sim::Protocol& protocol) {
  try {
    static_cast<void>(
        posterior::ranges_for(posterior::in_si_units({.parameters = {prior}}, protocol), protocol.ranges()));
  } catch (const Error& error) {
    const bool is_hinted = is_over_mgh && error.code() == Code::setting_out_of_range;
    throw Error(error.code(), option, error.where() + " " + error.problem(),
                error.remedy() + (is_hinted ? "; " + prior.name + "/mgh takes values over m g h" : ""));
  }
}

/// Throws Error naming the option for priors that the protocol's body cannot have. A range is valid or not by itself;
/// --fix and --prior also depend on the parameter's other options.
void check_priors(const std::vector<posterior::ParameterPrior>& all, const sim::Protocol& protocol) {
  for (const posterior::ParameterPrior& prior : all) {
    if (prior.range)
      check_option({.name = prior.name, .range = prior.range, .over_mgh = {.range = prior.over_mgh.range}}, "--range",
                   prior.over_mgh.range, protocol);
    if (prior.fixed) check_option(prior, "--fix", prior.over_mgh.fixed, protocol);
    if (prior.normal) check_option(prior, "--prior", prior.over_mgh.normal, protocol);
  }
}

/// Returns the priors that the texts give for the parameters of the protocol. has_sheet: as in parameter_priors().
std::vector<posterior::ParameterPrior> priors_of(const PriorTexts& texts, const sim::Protocol& protocol,
                                                 bool has_sheet) {
  using posterior::ParameterPrior;
  const sim::ParameterTable table = protocol.ranges();
  std::vector<ParameterPrior> all;
  const auto prior_of = [&](const std::string& name) -> ParameterPrior& {
    const auto found = std::ranges::find(all, name, &ParameterPrior::name);
    return found != all.end() ? *found : all.emplace_back(ParameterPrior{.name = name});
  };
  const auto read = [&](const std::vector<std::string>& of_option, std::size_t count, const char* option,
                        const char* form, auto member, bool ParameterPrior::OverMgh::*unit, const auto& value_of) {
    for (const std::string& text : of_option) {
      const NamedNumbers given(text, count, option, form, table);
      ParameterPrior& prior = prior_of(given.name);
      auto& value = prior.*member;
      if (value) throw Error(Code::setting_conflict, option, "is given twice for " + given.name, "give it once");
      value = value_of(given.numbers);
      prior.over_mgh.*unit = given.over_mgh;
    }
  };
  using Numbers = std::vector<double>;
  using OverMgh = ParameterPrior::OverMgh;
  read(texts.ranges, 2, "--range", "NAME=LOW,HIGH", &ParameterPrior::range, &OverMgh::range,
       [](const Numbers& numbers) {
         return ParameterPrior::Range{numbers[0], numbers[1]};
       });
  read(texts.normals, 2, "--prior", "NAME=MEAN,SD", &ParameterPrior::normal, &OverMgh::normal,
       [](const Numbers& numbers) {
         return ParameterPrior::Normal{numbers[0], numbers[1]};
       });
  read(texts.fixed, 1, "--fix", "NAME=VALUE", &ParameterPrior::fixed, &OverMgh::fixed,
       [](const Numbers& numbers) { return numbers[0]; });
  std::vector<ParameterPrior> checked = all;
  for (ParameterPrior& prior : checked)
    if (has_sheet && prior.range && prior.normal && prior.over_mgh.range != prior.over_mgh.normal) prior.normal.reset();
  check_priors(checked, protocol);
  return all;
}

/// Removes the texts for parameters that this controller does not have and another one of the call has.
PriorTexts for_controller(PriorTexts texts, const sim::BodyModel& controller,
                          const std::vector<const sim::BodyModel*>& all) {
  for (auto* list : {&texts.ranges, &texts.normals, &texts.fixed})
    std::erase_if(
        *list, [&](const std::string& text) { return is_of_another(NamedText(text).name.parameter, controller, all); });
  return texts;
}

}  // namespace

NamedText::NamedText(const std::string& text) : name(text.substr(0, text.find('='))) {
  if (const std::size_t equals = text.find('='); equals != std::string::npos) value = text.substr(equals + 1);
}

void add_prior_options(const Command& command, PriorTexts& priors) {
  command
      .add_option("--range", priors.ranges,
                  "Limit a parameter to the range from LOW to HIGH in its JSON unit, for example delay=0.05,0.2; "
                  "NAME/mgh: over the body's m g h, for example Kp/mgh=0.6,1.5; may be repeated")
      .repeatable()
      .shown_as("NAME[/mgh]=LOW,HIGH");
  command
      .add_option("--prior", priors.normals,
                  "Use a normal prior with this mean and standard deviation for a parameter, for example "
                  "delay=0.12,0.02, or over the body's m g h, for example Kp/mgh=1,0.2; default: uniform within its "
                  "range; may be repeated")
      .repeatable()
      .shown_as("NAME[/mgh]=MEAN,SD");
  command
      .add_option(
          "--fix", priors.fixed,
          "Fix a parameter at this value in its JSON unit, for example Kp=838.98, or over the body's m g h, for "
          "example Kp/mgh=1; may be repeated")
      .repeatable()
      .shown_as("NAME[/mgh]=VALUE");
}

std::vector<posterior::ParameterPrior> parameter_priors(const PriorTexts& texts, const sim::Protocol& protocol,
                                                        const std::vector<const sim::BodyModel*>& controllers,
                                                        bool has_sheet) {
  return priors_of(for_controller(texts, *protocol.experiment.body_model, controllers), protocol, has_sheet);
}

}  // namespace decid::tools
