// The command line: commands with options, as each command's file declares them. Only options.cpp includes the parser,
// CLI11, because its headers take seconds to compile.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace decid::tools {

/// Units that people give by mistake, each with its size in the option's unit: {"cm", 0.01} for metres. A value is
/// taken for the first of them in which it is a person's: from low to high.
struct OtherUnits {
  double low = 0.0, high = 0.0;
  std::vector<std::pair<std::string, double>> sizes{};
};

/// An option of a command; each call adds a property. Program::parse throws UsageError for values that the option
/// rejects.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option& required();
  /// Accepts numbers from low to high.
  Option& range(int low, int high);
  Option& range(long long low, long long high);
  /// others: the message of a value out of range names the value to give if it is in one of these units.
  Option& range(double low, double high, const char* unit = "", const OtherUnits& others = {});
  Option& one_of(const std::vector<std::string>& words);
  /// Accepts `min` to `max` values in sequence.
  Option& values(int min, int max);
  /// Accepts one value each time; the option may occur several times.
  Option& repeatable();
  /// Shows `text` in the help instead of the type and the default.
  Option& shown_as(const std::string& text);
  /// Changes the text before it is read. `rewrite` returns an error message, or an empty string if the text is valid.
  Option& rewritten(const std::function<std::string(std::string& text)>& rewrite, const std::string& type);
  Option& excludes(const Option& other);
  /// Leaves the option out of Command::given() and Command::arguments(): no output's content depends on it, or the
  /// call's record has its values elsewhere.
  Option& unrecorded();
  /// Marks the option as the name of an output file or folder, for Command::outputs().
  Option& output();
  /// Shows the option under this heading of the help, instead of its command's section.
  Option& section(const std::string& heading);

 private:
  CLI::Option* option_;
};

class Command {
 public:
  explicit Command(CLI::App* app) : app_(app) {}

  Command add_subcommand(const std::string& name, const std::string& description) const;
  /// Requires one of the subcommands.
  void require_subcommand() const;

  /// Adds an option. `names`: "-o,--output", or "model" without dashes for a positional argument. `value` must live
  /// until the program has been parsed; the help shows its value as the default, if it has one and the description does
  /// not say "default:". T: std::string, int, long long, std::uint64_t, double; std::optional of
  /// std::string, int or double; std::vector of std::string or double.
  template <class T>
  Option add_option(const std::string& names, T& value, const std::string& description) const;
  Option add_flag(const std::string& names, bool& value, const std::string& description) const;

  /// Shows the options that follow under this heading of the help.
  void section(const std::string& heading) const;
  /// Adds text below the options in the help.
  void footer(const std::string& text) const;
  /// Sets the function that runs after all arguments have been read.
  void callback(std::function<void()> work) const;
  /// Returns "--option value value" for each given recorded option except `without`. Call it in a callback.
  std::vector<std::string> given(const std::vector<std::string>& without) const;
  /// Returns the given recorded options as arguments of a later call: "--option=value", "--flag".
  std::vector<std::string> arguments() const;
  /// Returns the words that name the command in a call: "fit", "export c".
  std::string name() const;
  /// Returns the name and the last value of each given option of Option::output(). Call it in a callback.
  std::vector<std::pair<std::string, std::string>> outputs() const;
  /// Returns how often an option was given. Call it in a callback.
  std::size_t count(const std::string& option) const;

 private:
  CLI::App* app_;
};

/// An error in the arguments of a call.
struct UsageError {
  std::string message;
  std::string command;  ///< of the call, with its subcommands: "export sway"; empty if there was none
};

class Program {
 public:
  Program(const std::string& name, const std::string& description, const std::string& version);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  Command top() const;
  /// Reads the arguments and runs the command, or prints help or version. Throws UsageError and every exception of the
  /// command.
  void parse(int argc, char** argv) const;

 private:
  std::unique_ptr<CLI::App> app_;
};

}  // namespace decid::tools
