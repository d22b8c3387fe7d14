// The command line program. Exit codes: 0 for success, 2 for wrong usage or bad input (one line on stderr), 1 for
// anything else. Ctrl-C and SIGTERM end it by the signal (130 and 143 in a shell).
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <new>
#include <string_view>

#include "base/error.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "nn/kernels/kernels.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/interrupt.hpp"
#include "tools/decid/ranks.hpp"

#if defined(__GLIBC__) && !defined(DECID_SANITIZED)
#include <malloc.h>
#include <sys/mman.h>
#endif

namespace {

/// Configures the heap, before the first allocation; the libraries leave it to the calling program. It begins with
/// large pages where the system has them, and keeps freed memory for later allocations. Identifying one recording takes
/// some 20 MB in blocks of up to 3 MB. By default the C library maps such blocks and returns them, and every page of 4
/// KB traps when it is touched. These settings save 18 of 63 ms from start to exit (EPYC Zen 3, fastest of 60 calls of
/// decid identify). A sanitizer has its own heap.
void prepare_heap() {
#if defined(__GLIBC__) && !defined(DECID_SANITIZED)
  constexpr int block = 32 << 20;   // what the C library's own threshold grows to, in time
  constexpr int large = 128 << 20;  // of addresses, which cost nothing: the results of 400 recordings
  constexpr std::uintptr_t page = 2 << 20, least = 256 << 10, small_page = 4 << 10;
  mallopt(M_MMAP_THRESHOLD, block);
  mallopt(M_TRIM_THRESHOLD, large + 2 * block);
  // Eight cores share a heap, because only the first heap has large pages. Each thread caches small blocks itself. A
  // recording takes a few hundred large blocks, so threads seldom wait for each other.
  mallopt(M_ARENA_MAX, static_cast<int>(std::max(1L, sysconf(_SC_NPROCESSORS_ONLN) / 8)));
  char* const begin = static_cast<char*>(sbrk(0));  // the heap's end
  const std::uintptr_t to_page = page - reinterpret_cast<std::uintptr_t>(begin) % page;
  char* const first = begin + (to_page < least ? to_page + page : to_page);
  // Memory before the first large page stays unused, because it would be touched 4 KB at a time. The allocation is
  // larger than the rest of the heap, so the heap grows by the allocation and by `large`. It ends before the first
  // large page, which nothing has touched yet: the system does not enlarge a page that contains a touched small page.
  // Without volatile, the compiler could remove the unused allocation.
  mallopt(M_TOP_PAD, large);
  void* volatile unused = std::malloc(static_cast<std::size_t>(first - begin) - small_page);
  mallopt(M_TOP_PAD, 1 << 20);
  char* const end = static_cast<char*>(sbrk(0));
  // A failure costs only time.
  if (unused != nullptr && first + page <= end)
    static_cast<void>(madvise(first, static_cast<std::size_t>(end - first) / page * page, MADV_HUGEPAGE));
#endif
}

void say(const std::string& text) {
  std::cerr << "decid: " << decid::one_line(text) << '\n';
}

constexpr std::string_view no_memory =
    "not enough memory; ask for fewer trials, a smaller batch or a shorter recording";

/// Where an exception may not pass: destructors of JSON allocate. Nothing here does.
[[noreturn]] void end_at_once() {
  try {
    throw;
  } catch (const std::bad_alloc&) {
    for (const std::string_view part : {std::string_view("decid: "), no_memory, std::string_view("\n")})
      if (::write(STDERR_FILENO, part.data(), part.size()) < 0) break;
    std::_Exit(1);
  } catch (...) {
    std::abort();
  }
}

/// Rejects empty arguments: a shell makes them from unset variables, and no option gives them a meaning.
void refuse_empty(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const bool after_equals = argument.starts_with("--") && argument.ends_with('=');
    if (!argument.empty() && !after_equals) continue;
    const std::string what = after_equals ? argument : i > 1 ? std::string(argv[i - 1]) + " ''" : "''";
    throw decid::Error(decid::Code::setting_missing, what, "is empty",
                       "give a value, or leave the option out (is a variable of the shell not set?)");
  }
}

/// Returns the command line option that corresponds to a setting of the library.
std::string option_of(std::string_view setting) {
  if (setting == "learning_rate") return "--lr";
  if (setting == "trial_column") return "--trial";
  if (setting == "ranges") return "--range";
  std::string option = "--" + std::string(setting);
  std::ranges::replace(option, '_', '-');
  return option;
}

/// No single write reports a full disk.
void require_written_output() {
  std::cout.flush();
  if (!std::cout) throw decid::WriteError("standard output", "cannot be written", "is the disk full?");
}

/// How the work ended.
struct Ending {
  int code;
  std::string text;
};

Ending run(int argc, char** argv, const decid::tools::Session& session) {
  const decid::tools::Program program(
      "decid", "Estimate balance-control parameters from recordings of sway on a tilting platform",
      std::string("decid ") + decid::version);
  const decid::tools::Command top = program.top();
  top.require_subcommand();
  top.footer(
      "Examples:\n  decid identify recording.csv --report report.html\n"
      "  decid fit recording.csv --mass 70 --height 1.75 -o result.json\n"
      "  decid simulate --kp 900 --seed 7 -o trial.csv");
  decid::tools::add_identify(top);
  decid::tools::add_fit(top);
  decid::tools::add_simulate(top);
#if !defined(__wasm__)  // a page (bindings/web) simulates, identifies and fits
  decid::tools::add_stimulus(top);
  decid::tools::add_info(top);
  decid::tools::add_rerun(top);
  decid::tools::add_calibrate(top);
  decid::tools::add_compare(top);
  decid::tools::add_dataset(top);
  decid::tools::add_train(top);
  decid::tools::add_evaluate(top);
  decid::tools::add_study(top);
  decid::tools::add_design(top);
  decid::tools::add_power(top);
  decid::tools::add_image(top);
  decid::tools::add_export(top);
  decid::tools::add_selftest(top);
#endif
  session.require_alike(decid::tools::output_options());
  if (!session.takes_part()) return {0, {}};
  refuse_empty(argc, argv);
  try {
    program.parse(argc, argv);
  } catch (const decid::tools::UsageError& error) {
    if (error.command.empty() && argc > 1 && argv[1][0] != '-')
      throw decid::Error(decid::Code::setting_unknown, argv[1], "is not a command", "decid --help lists the commands");
    const std::string help = error.command.empty() ? std::string() : " " + error.command;
    return {2, error.message + "; see decid" + help + " --help"};
  }
  require_written_output();
  return {0, {}};
}

Ending run_to_its_end(int argc, char** argv, const decid::tools::Session& session) {
  try {
    return run(argc, argv, session);
  } catch (const decid::WriteError& error) {
    return {1, error.what()};
  } catch (const decid::Error& error) {
    return {2, error.what()};
  } catch (const std::bad_alloc&) {
    return {1, std::string(no_memory)};
  } catch (const std::exception& error) {
    return {1, error.what()};
  }
}

}  // namespace

int main(int argc, char** argv) {
  prepare_heap();
  decid::name_settings(option_of);
  std::set_terminate(end_at_once);
  decid::tools::end_at_interrupt();
#if defined(SIGXFSZ)
  std::signal(SIGXFSZ,
              SIG_IGN);  // a file beyond the shell's limit is an error of its write, with a line and a clean-up
#endif
  int code = 0;
  bool alone = true;
  try {
    decid::tools::Session session(argc, argv);
    alone = decid::tools::ranks() == nullptr;
    const Ending ending = run_to_its_end(argc, argv, session);
    code = session.end(ending.code, ending.text, say);
  } catch (const decid::Error& error) {  // of MPI itself
    say(error.what());
    return 2;
  }
  if (alone) decid::tools::end_if_interrupted();  // mpirun would take the signal of one for a crash
  return code;
}
