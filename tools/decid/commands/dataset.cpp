// decid dataset: simulated trials with known parameters, as a file for training and for NumPy.
#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "dataset/npz/npz.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/interrupt.hpp"
#include "tools/decid/progress.hpp"
#include "tools/decid/ranks.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/report/dataset_page.hpp"

namespace decid::tools {
namespace {

struct DatasetOptions {
  CommonOptions common;
  int count = 0, base = 0;
  std::uint64_t seed = 1;
  ProtocolOptions protocol;
  std::string output, report;
};

std::string table_line(const std::string& name, const std::string& unit, const dataset::Distribution& base,
                       const dataset::Distribution* enriched) {
  std::string line = format("%-12s %-9s", name.c_str(), unit.c_str());
  for (const dataset::Distribution* values : {&base, enriched})
    if (values)
      line += format("  %9.5g %9.5g %9.5g %9.5g", values->mean(), values->stddev(), values->min(), values->max());
  return line + '\n';
}

/// The paper's table, before and after enrichment.
std::string table(const sim::ParameterTable& parameters, const dataset::DatasetReport& report) {
  const bool children = report.child_attempts > 0;
  const std::string columns = format("  %9s %9s %9s %9s", "mean", "sd", "min", "max");
  std::string text = format("%-22s  %-39s", "", children ? "before enrichment" : "");
  text += children ? "  after enrichment\n" : "\n";
  if (!children) text.clear();
  text += format("%-12s %-9s", "parameter", "unit") + columns + (children ? columns : "") + '\n';
  for (std::size_t i = 0; i < parameters.size(); ++i)
    text += table_line(parameters[i].name, parameters[i].shown_unit(), report.base.parameters[i],
                       children ? &report.all.parameters[i] : nullptr);
  return text +
         table_line("peak to peak", "rad", report.base.peak_to_peak, children ? &report.all.peak_to_peak : nullptr);
}

std::string megabytes(std::uint64_t bytes) {
  return bytes < 10'000'000'000 ? format("%.1f MB", static_cast<double>(bytes) * 1e-6)
                                : format("%.1f GB", static_cast<double>(bytes) * 1e-9);
}

std::string summary(const DatasetFigures& figures, double seconds) {
  const dataset::DatasetReport& report = figures.report;
  const long long base = report.base.peak_to_peak.count(), trials = report.all.peak_to_peak.count();
  std::string text = format("%lld trials in %s, %s, written to %s\n", trials, duration_text(seconds).c_str(),
                            megabytes(figures.bytes).c_str(), figures.file.c_str());
  text += format("base: %lld of %lld attempts valid (%.1f%%); %s (above %g rad peak to peak)\n", base,
                 report.base_attempts, 100.0 * static_cast<double>(base) / static_cast<double>(report.base_attempts),
                 counted(report.parents, "parent").c_str(), dataset::parent_peak_to_peak_rad);
  if (report.child_attempts > 0)
    text += format("children: %lld of %lld attempts valid (%.1f%%)\n", trials - base, report.child_attempts,
                   100.0 * static_cast<double>(trials - base) / static_cast<double>(report.child_attempts));
  return text + table(figures.request.protocol.parameters(), report);
}

/// Warns before the work if space is short. The work continues: the user may free space meanwhile, and decid keeps
/// finished trials.
void warn_of_little_space(const DatasetOptions& options, std::uint64_t bytes, const dataset::NpzPartial& partial) {
  std::error_code error;
  const auto folder = std::filesystem::path(partial.file).parent_path();
  const auto space = std::filesystem::space(folder.empty() ? "." : folder, error);
  const std::uint64_t there =
      std::filesystem::exists(partial.file, error) ? std::filesystem::file_size(partial.file, error) : 0;
  // A file system that holds no files, /proc for one, has no size.
  if (error || space.capacity == 0 || options.common.quiet || space.available + there >= bytes) return;
  std::cerr << format(
      "warning: %s needs %s, its disk has %s left; if the disk is full the work stops; the same command continues when "
      "there is space\n",
      options.output.c_str(), megabytes(bytes).c_str(), megabytes(space.available).c_str());
}

void make_dataset(const DatasetOptions& options, const Command& command) {
  DatasetFigures figures;
  figures.file = options.output;
  figures.version = version;
  std::vector<std::string> files;
  figures.request = {options.protocol.load(options.common.quiet, &files), options.count, options.base, options.seed};
  const bool reports = is_root() && (options.common.json || !options.report.empty());
  if (reports) figures.call = record_call(command, files);
  figures.call.seed = options.seed;
  refuse_same_file(options.report, files);
  files.push_back(options.report);
  const dataset::NpzPartial partial = dataset::npz_partial(options.output);
  for (const std::string& path : {options.output, partial.file.string(), partial.journal.string()})
    refuse_same_file(path, files);
  std::unique_ptr<PendingFile> probe;  // reports an unwritable place before the work, not after
  if (!options.report.empty() && is_root()) probe = std::make_unique<PendingFile>(options.report);
  probe.reset();
  warn_of_little_space(options, dataset::npz_bytes(options.count, figures.request.protocol), partial);

  catch_interrupt();
  const auto start = std::chrono::steady_clock::now();
  int done = 0;
  try {
    ProgressBar bar("dataset", "trials", options.count, options.common.quiet);
    figures.report = dataset::generate_npz(
        options.output, figures.request, std::string("decid ") + version,
        [&](int trials, int) {
          bar.update(done = trials);
          return !interrupted();
        },
        [&](int trials) {
          bar.line(format("resuming at trial %d of %d (%s)", trials, options.count, partial.file.c_str()));
          bar.go_on_from(trials);
        },
        ranks());
  } catch (const Error&) {
    if (!interrupted()) throw;
    throw std::runtime_error(format("stopped at trial %d of %d; the same command continues from there (%s)", done,
                                    options.count, partial.file.c_str()));
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  figures.bytes = std::filesystem::file_size(options.output);
  if (reports) figures.sha256 = hash_file(options.output);
  if (!options.report.empty() && is_root()) write_file(options.report, dataset_html(figures));
  if (!options.common.quiet) std::cerr << summary(figures, seconds);
  if (options.common.json) std::cout << print_json(dataset_json(figures)) << '\n';
}

}  // namespace

void add_dataset(const Command& program) {
  auto options = std::make_shared<DatasetOptions>();
  const Command command = program.add_subcommand("dataset", "Simulate a data set of valid trials");
  command.section("Trials");
  command.add_option("--count", options->count, "Simulate this many valid trials in all")
      .required()
      .range(1, 10'000'000);
  command.add_option("--base", options->base,
                     "Draw this many of them from the uniform distributions, and the rest around trials with large "
                     "sway; default: all");
  add_seed_option(command, options->seed, "Seed the trials");
  add_protocol_options(command, options->protocol);
  add_output_option(command, "-o,--output", options->output, Written::npz,
                    "Write this .npz file; if stopped, the same command continues from OUTPUT.partial")
      .required();
  add_output_option(command, "--report", options->report, Written::html,
                    "Write acceptance rates and the distributions of parameters and sway to this HTML page");
  command.footer(
      "Examples:\n"
      "  decid dataset --count 2000 --seed 99 -o test.npz\n"
      "  decid dataset --count 10000 --protocol mine.json --sensor-noise 0.001 0.1 -o noisy.npz\n"
      "  decid dataset --count 12766 --base 10000 --seed 1 -o data.npz --report data.html\n"
      "The last example makes the paper's data set.");
  run_with(command, options, true, make_dataset);
}

}  // namespace decid::tools
