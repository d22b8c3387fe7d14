// Options that all subcommands have.
#include <omp.h>

#include "tools/command.hpp"

namespace decid::tools {

void add_common_options(CLI::App& command, CommonOptions& options, bool prints_figures) {
  command.add_option("--threads", options.threads, "Threads to use; default: all cores. The result is the same")
      ->check(CLI::Range(1, 1024));
  command.add_flag("--quiet", options.quiet, "No progress and no messages, only errors");
  if (prints_figures) command.add_flag("--json", options.json, "Print one JSON object on standard output");
}

void apply(const CommonOptions& options) {
  if (options.threads > 0) omp_set_num_threads(options.threads);
}

}  // namespace decid::tools
