// decid fit --frf: see fit_frf.hpp.
#include "tools/decid/commands/fit_frf.hpp"

#include <chrono>
#include <iostream>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "tools/decid/results/frf_results.hpp"
#include "tools/report/frf_page.hpp"
#include "tools/report/json/recording_json.hpp"

namespace decid::tools {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

void compare(std::vector<FrfAnswer>& answers, const frf::SmcSettings& particles) {
  std::vector<std::vector<double>> pointwise;
  for (FrfAnswer& answer : answers) {
    answer.left_out = frf::leave_rows_out(answer.density, answer.found, particles);
    pointwise.push_back(answer.left_out.pointwise);
  }
  const std::vector<posterior::ComparedModel> compared = posterior::compare_models(pointwise);
  for (std::size_t i = 0; i < answers.size(); ++i) answers[i].compared = compared[i];
}

void write(const FrfFit& asked, Json result, const std::string& text) {
  add_call(result, asked.call);
  const std::string json = print_json(result) + "\n";  // bytes of a file name that are not UTF-8 are replaced
  if (!asked.output.empty()) write_file(asked.output, json);
  std::cout << (asked.json ? json : text);
}

void run_log_ratio(const FrfFit& asked, const frf::Table& table) {
  if (!asked.draws.empty() || !asked.page.empty())
    throw Error(Code::setting_conflict, asked.page.empty() ? "--draws" : "--report",
                "cannot be combined with --objective log-ratio, which has no draws", "leave it out");
  const auto begin = Clock::now();
  LogRatioReport report{{}, asked.truth, 0.0, asked.options, asked.body_assumed};
  for (const FrfFit::Controller& controller : asked.controllers) {
    const frf::Density density(controller.protocol, table, controller.priors);
    report.answers.push_back({density, frf::fit_log_ratio(density, {.seed = asked.particles.seed})});
  }
  report.seconds = seconds_since(begin);
  write(asked, log_ratio_object(report), log_ratio_text(report));
}

}  // namespace

void run_frf_fit(const FrfFit& asked) {
  const frf::Table table = frf::read_table(asked.table);
  if (asked.log_ratio) return run_log_ratio(asked, table);
  const auto begin = Clock::now();
  FrfReport report{{}, asked.truth, 0.0, asked.options, asked.body_assumed};
  for (const FrfFit::Controller& controller : asked.controllers) {
    const frf::Density density(controller.protocol, table, controller.priors);
    report.answers.push_back({density, frf::fit(density, asked.particles)});
  }
  if (report.answers.size() > 1) compare(report.answers, asked.particles);
  report.seconds = seconds_since(begin);
  if (!asked.draws.empty()) write_frf_draws(asked.draws, report);
  const Json found = frf_fit_object(report);
  if (!asked.page.empty()) write_file(asked.page, frf_page(found, asked.call));
  write(asked, found, frf_fit_text(report));
}

}  // namespace decid::tools
