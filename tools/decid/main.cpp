// The command line program. Exit codes: 0 done, 2 wrong usage or bad input (one line on stderr), 1 anything else; it
// ends by Ctrl-C and SIGTERM (130 and 143 in a shell).
#include <csignal>
#include <exception>
#include <iostream>

#include "base/error.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "nn/kernels/kernels.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/interrupt.hpp"

namespace {

void complain(const std::string& text) {
  std::cerr << "decid: " << decid::one_line(text) << '\n';
}

/// Refuses empty arguments: a shell makes them of variables that are not set, and no option means anything by them.
void refuse_empty(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const bool after_equals = argument.starts_with("--") && argument.ends_with('=');
    if (!argument.empty() && !after_equals) continue;
    const std::string what = after_equals ? argument : i > 1 ? std::string(argv[i - 1]) + " ''" : "''";
    throw decid::Error(what, "is empty", "give a value, or leave the option out (is a variable of the shell not set?)");
  }
}

/// No single write reports a full disk.
void require_written_output() {
  std::cout.flush();
  if (!std::cout) throw std::runtime_error("standard output: cannot be written; is the disk full?");
}

int run(int argc, char** argv) {
  refuse_empty(argc, argv);
  const decid::tools::Program program(
      "decid", "decid identifies the posture controller behind a recording of body sway on a tilting platform",
      std::string("decid ") + decid::version);
  const decid::tools::Command top = program.top();
  top.require_subcommand();
  top.footer("Example: decid identify recording.csv --report report.html");
  decid::tools::add_identify(top);
  decid::tools::add_fit(top);
  decid::tools::add_calibrate(top);
  decid::tools::add_compare(top);
  decid::tools::add_simulate(top);
  decid::tools::add_stimulus(top);
  decid::tools::add_dataset(top);
  decid::tools::add_train(top);
  decid::tools::add_evaluate(top);
  decid::tools::add_study(top);
  decid::tools::add_image(top);
  decid::tools::add_info(top);
  decid::tools::add_export(top);
  try {
    program.parse(argc, argv);
  } catch (const decid::tools::UsageError& error) {
    if (error.command.empty() && argc > 1 && argv[1][0] != '-')
      throw decid::Error(argv[1], "is not a command", "decid --help lists the commands");
    const std::string help = error.command.empty() ? std::string() : " " + error.command;
    complain(error.message + "; see decid" + help + " --help");
    return 2;
  }
  require_written_output();
  return 0;
}

/// The exit code.
int run_and_complain(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const decid::Error& error) {
    complain(error.what());
    return 2;
  } catch (const std::bad_alloc&) {
    complain("not enough memory; ask for fewer trials, a smaller batch or a shorter recording");
    return 1;
  } catch (const std::exception& error) {
    complain(error.what());
    return 1;
  }
}

}  // namespace

int main(int argc, char** argv) {
  decid::tools::end_at_interrupt();
#if defined(SIGXFSZ)
  std::signal(SIGXFSZ,
              SIG_IGN);  // a file beyond the shell's limit is an error of its write, with a line and a clean-up
#endif
  const int code = run_and_complain(argc, argv);
  decid::tools::end_if_interrupted();
  return code;
}
