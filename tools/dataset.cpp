// decid dataset: simulated trials with known parameters, as a file for training and for NumPy.
#include <chrono>
#include <iostream>
#include <memory>

#include "base/error.hpp"
#include "base/file.hpp"
#include "dataset/npz.hpp"
#include "tools/command.hpp"
#include "tools/progress.hpp"
#include "tools/text.hpp"

namespace decid::tools {
namespace {

struct Options {
  CommonOptions common;
  int count = 0, base = 0;
  std::uint64_t seed = 1;
  ProtocolOptions protocol;
  std::string output;
};

void make_dataset(const Options& options) {
  catch_interrupt();
  { PendingFile probe(options.output); }  // an unwritable place is told before the work, not after
  dataset::DatasetRequest request;
  request.protocol = options.protocol.load();
  request.count = options.count;
  request.base = options.base;
  request.seed = options.seed;
  const auto start = std::chrono::steady_clock::now();
  dataset::DatasetReport report;
  dataset::Dataset data;
  try {
    ProgressBar bar("dataset", "trials", options.count, options.common.quiet);
    data = dataset::generate(request, &report, [&](int done, int) {
      bar.update(done);
      return !interrupted();
    });
  } catch (const Error&) {
    if (interrupted()) throw std::runtime_error("stopped; nothing was written");
    throw;
  }
  dataset::write_npz(options.output, data);
  if (options.common.quiet) return;
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const int base = options.base > 0 ? options.base : options.count;
  std::cerr << format("%d trials in %s, written to %s\n", data.trials(), duration_text(seconds).c_str(),
                      options.output.c_str());
  std::cerr << format("base: %d of %lld attempts valid (%.1f%%); %d parents", base, report.base_attempts,
                      100.0 * base / static_cast<double>(report.base_attempts), report.parents);
  if (report.child_attempts > 0)
    std::cerr << format("; children: %d of %lld attempts valid", data.trials() - base, report.child_attempts);
  std::cerr << '\n';
}

}  // namespace

void add_dataset(CLI::App& program) {
  auto options = std::make_shared<Options>();
  CLI::App* command = program.add_subcommand("dataset", "Simulate a data set of valid trials");
  command->add_option("--count", options->count, "Valid trials in all")->required()->check(CLI::Range(1, 10'000'000));
  command->add_option("--base", options->base,
                      "Of these, how many come from the uniform distributions; the rest are "
                      "children of trials with large sway. Default: all");
  command->add_option("--seed", options->seed, "Seed")->capture_default_str()->check(CLI::NonNegativeNumber);
  add_protocol_options(*command, options->protocol);
  command->add_option("-o,--output", options->output, ".npz file to write")->required();
  add_common_options(*command, options->common, false);
  command->footer("Example, the paper's set: decid dataset --count 12766 --base 10000 --seed 1 -o data.npz");
  command->callback([options] {
    apply(options->common);
    make_dataset(*options);
  });
}

}  // namespace decid::tools
