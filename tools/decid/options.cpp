// The command line: see options.hpp.
#include "tools/decid/options.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

#include "base/text.hpp"

namespace decid::tools {
namespace {

/// Accepts numbers of a type from low to high. shown: the range, in messages and in the help. others: see
/// Option::range().
template <class Number>
CLI::Validator between(Number low, Number high, const std::string& shown, const OtherUnits& others = {}) {
  return {[=](const std::string& text) {
            Number value{};
            if (!CLI::detail::lexical_cast(text, value) && text.find_first_not_of("+-.,0123456789eE") == text.npos &&
                text.find(',') != text.npos)
              return text + " is not a number; write decimals with a point";
            const bool is_number = CLI::detail::lexical_cast(text, value);
            if (is_number && value >= low && value <= high) return std::string();
            std::string problem = text + " is not from " + shown;
            for (const auto& [unit, size] : others.sizes) {
              const double converted = static_cast<double>(value) * size;
              if (is_number && converted >= others.low && converted <= others.high)
                return problem + format("; if it is in %s, give %.4g", unit.c_str(), converted);
            }
            return problem;
          },
          "in " + shown};
}

/// Returns the text of an error; that of a value in the form of Option::range().
std::string message_of(const CLI::ParseError& error) {
  std::string text = error.what();
  if (text.starts_with(": ")) text.erase(0, 2);  // the name of an option that help does not show
  const std::string once = ": At Most 1 required but received ";
  if (const std::size_t place = text.find(once); place != std::string::npos)
    return text.substr(0, place) + ": is given " + text.substr(place + once.size()) + " times; give it once";
  const std::string begin = "Could not convert: ";
  const std::size_t equals = text.find(" = ");
  if (!text.starts_with(begin) || equals == std::string::npos) return text;
  return text.substr(begin.size(), equals - begin.size()) + ": " + text.substr(equals + 3) + " is not a valid number";
}

/// The name of a check that accepts everything and marks an option as an output.
constexpr const char* output_mark = "output";

bool is_output(CLI::Option& option) {
  try {
    return option.get_validator(output_mark) != nullptr;
  } catch (const CLI::OptionNotFound&) {
    return false;
  }
}

}  // namespace

Option& Option::required() {
  option_->required()->default_str("");
  return *this;
}

Option& Option::range(int low, int high) {
  option_->check(between(low, high, format("%d to %d", low, high)));
  return *this;
}

Option& Option::range(long long low, long long high) {
  option_->check(between(low, high, format("%lld to %lld", low, high)));
  return *this;
}

Option& Option::range(double low, double high, const char* unit, const OtherUnits& others) {
  option_->check(between(low, high, format("%g to %g%s%s", low, high, *unit == '\0' ? "" : " ", unit), others));
  return *this;
}

Option& Option::one_of(const std::vector<std::string>& words) {
  option_->check(CLI::Validator(
      [=](const std::string& text) {
        return std::ranges::find(words, text) != words.end() ? std::string()
                                                             : text + " is not one of " + joined(words, ", ");
      },
      "{" + joined(words, ",") + "}"));
  return *this;
}

Option& Option::values(int min, int max) {
  option_->expected(min, max);
  return *this;
}

Option& Option::repeatable() {
  option_->expected(1)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  return *this;
}

Option& Option::shown_as(const std::string& text) {
  option_->option_text(text);
  return *this;
}

Option& Option::rewritten(const std::function<std::string(std::string&)>& rewrite, const std::string& type) {
  option_->transform(CLI::Validator(rewrite, type));
  return *this;
}

Option& Option::excludes(const Option& other) {
  option_->excludes(other.option_);
  return *this;
}

Option& Option::unrecorded() {
  option_->configurable(false);  // CLI11's mark of options that it leaves out of a saved configuration
  return *this;
}

Option& Option::output() {
  option_->check(CLI::Validator(""), output_mark);
  return *this;
}

Option& Option::section(const std::string& heading) {
  option_->group(heading);
  return *this;
}

Command Command::add_subcommand(const std::string& name, const std::string& description) const {
  return Command(app_->add_subcommand(name, description));
}

void Command::require_subcommand() const {
  app_->require_subcommand(1);
}

template <class T>
Option Command::add_option(const std::string& names, T& value, const std::string& description) const {
  CLI::Option* const option = app_->add_option(names, value, description);
  bool has_default = true;
  if constexpr (requires { value.empty(); }) has_default = !value.empty();
  if constexpr (requires { value.has_value(); }) has_default = value.has_value();
  if (has_default && description.find("default:") == std::string::npos) option->capture_default_str();
  return Option(option);
}
template Option Command::add_option(const std::string&, std::string&, const std::string&) const;
template Option Command::add_option(const std::string&, int&, const std::string&) const;
template Option Command::add_option(const std::string&, long long&, const std::string&) const;
template Option Command::add_option(const std::string&, std::uint64_t&, const std::string&) const;
template Option Command::add_option(const std::string&, double&, const std::string&) const;
template Option Command::add_option(const std::string&, std::optional<std::string>&, const std::string&) const;
template Option Command::add_option(const std::string&, std::optional<int>&, const std::string&) const;
template Option Command::add_option(const std::string&, std::optional<double>&, const std::string&) const;
template Option Command::add_option(const std::string&, std::vector<std::string>&, const std::string&) const;
template Option Command::add_option(const std::string&, std::vector<double>&, const std::string&) const;

Option Command::add_flag(const std::string& names, bool& value, const std::string& description) const {
  return Option(app_->add_flag(names, value, description));
}

void Command::section(const std::string& heading) const {
  app_->option_defaults()->group(heading);
}

void Command::footer(const std::string& text) const {
  app_->footer(text);
}

void Command::callback(std::function<void()> work) const {
  app_->callback(std::move(work));
}

std::vector<std::string> Command::given(const std::vector<std::string>& without) const {
  std::vector<std::string> all;
  for (const CLI::Option* option : app_->get_options()) {
    const bool is_left_out =
        !option->get_configurable() || std::ranges::find(without, option->get_name()) != without.end();
    if (option->count() == 0 || is_left_out) continue;
    std::string& text = all.emplace_back(option->get_name());
    for (const std::string& value : option->results()) text += ' ' + value;
  }
  return all;
}

std::vector<std::string> Command::arguments() const {
  std::vector<std::string> all;
  for (const CLI::Option* option : app_->get_options()) {
    if (option->count() == 0 || !option->get_configurable()) continue;
    const std::string name = option->get_name();
    const bool is_flag = option->get_items_expected_max() == 0;
    if (is_flag) all.push_back(name);
    for (const std::string& value : option->results())
      if (!is_flag) all.push_back(name.starts_with('-') ? name + "=" + value : value);
  }
  return all;
}

std::string Command::name() const {
  std::string name = app_->get_name();
  const CLI::App* parent = app_->get_parent();
  for (; parent != nullptr && parent->get_parent() != nullptr; parent = parent->get_parent())
    name = parent->get_name() + " " + name;
  return name;
}

std::vector<std::pair<std::string, std::string>> Command::outputs() const {
  std::vector<std::pair<std::string, std::string>> all;
  for (CLI::Option* option : app_->get_options())
    if (option->count() > 0 && is_output(*option)) all.emplace_back(option->get_name(), option->results().back());
  return all;
}

std::size_t Command::count(const std::string& option) const {
  return app_->count(option);
}

Program::Program(const std::string& name, const std::string& description, const std::string& version)
    : app_(std::make_unique<CLI::App>(description)) {
  app_->name(name);
  app_->set_version_flag("--version", version);
}

Program::~Program() = default;

Command Program::top() const {
  return Command(app_.get());
}

void Program::parse(int argc, char** argv) const {
  try {
    app_->parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // --help, --version
      app_->exit(error);
      return;
    }
    std::string command;
    for (std::vector<CLI::App*> given = app_->get_subcommands(); !given.empty();) {
      command += (command.empty() ? "" : " ") + given.back()->get_name();
      given = given.back()->get_subcommands();
    }
    throw UsageError{message_of(error), command};
  }
}

}  // namespace decid::tools
