// The command line: commands with options, as each command's file declares them. options.cpp alone includes the parser,
// CLI11, whose headers take seconds to compile wherever they are.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace decid::tools {

/// An option of a command; each call says more of it. Values that it refuses are a UsageError of Program::parse.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  Option& required();
  /// What the variable holds now stands in the help.
  Option& show_default();
  /// Numbers from low to high.
  Option& range(int low, int high);
  Option& range(long long low, long long high);
  Option& range(double low, double high, const char* unit = "");
  Option& one_of(const std::vector<std::string>& words);
  /// So many values, one after the other.
  Option& values(int least, int most);
  /// One value, and the option may be given several times.
  Option& repeatable();
  /// In place of the type and the default that the help would show.
  Option& shown_as(const std::string& text);
  /// Changes the text before it is read; what it returns, unless empty, is what is wrong with it.
  Option& rewritten(const std::function<std::string(std::string& text)>& rewrite, const std::string& type);
  Option& excludes(const Option& other);
  /// The heading of the help under which it stands, instead of its command's section.
  Option& section(const std::string& heading);

 private:
  CLI::Option* option_;
};

class Command {
 public:
  explicit Command(CLI::App* app) : app_(app) {}

  Command add_subcommand(const std::string& name, const std::string& description) const;
  /// One of them has to be given.
  void require_subcommand() const;

  /// `names`: "-o,--output", or "model" without dashes for what stands alone. `value` must live until the program has
  /// been parsed. T: std::string, int, long long, std::uint64_t, double; std::optional of std::string, int or double;
  /// std::vector of std::string or double.
  template <class T>
  Option add_option(const std::string& names, T& value, const std::string& description) const;
  Option add_flag(const std::string& names, bool& value, const std::string& description) const;

  /// The heading of the help under which the options that follow stand.
  void section(const std::string& heading) const;
  /// Below the options in the help.
  void footer(const std::string& text) const;
  /// Called once everything has been read.
  void callback(std::function<void()> work) const;
  /// "--option value value" of everything that was given, but for these; in a callback.
  std::vector<std::string> given(const std::vector<std::string>& without) const;
  /// How often an option was given; in a callback.
  std::size_t count(const std::string& option) const;

 private:
  CLI::App* app_;
};

/// What a call of the program has wrong.
struct UsageError {
  std::string message;
  std::string command;  ///< that was asked for; empty if none was
};

class Program {
 public:
  Program(const std::string& name, const std::string& description, const std::string& version);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  Command top() const;
  /// Reads the arguments and calls the command's work, or prints help or version. Throws UsageError, and whatever the
  /// work throws.
  void parse(int argc, char** argv) const;

 private:
  std::unique_ptr<CLI::App> app_;
};

}  // namespace decid::tools
