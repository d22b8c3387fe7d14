// Fitted recordings for pages: a short simulated one, the same with an odd name, and one that cannot be read.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "identify/fit_recordings.hpp"
#include "sim/streams.hpp"
#include "tests/sim/sines.hpp"
#include "tools/report/fit_page.hpp"

namespace decid::test {

inline const char* const hostile_name = "</script><script>document.body.dataset.error='markup'</script>.csv";

inline FitRequest quick_request() {
  FitRequest request;
  request.settings = {.seed = 5,
                      .groups = 1,
                      .annealing_transitions = 5,
                      .window_transitions = 9,
                      .max_leapfrog_steps = 60,
                      .block = 20,
                      .min_draws = 40,
                      .max_draws = 40};
  return request;
}

/// Returns the report of the recordings: the first one compares its controller with itself, and the last one's chains
/// are marked as disagreeing.
inline Report fitted_recordings() {
  const sim::Protocol protocol = three_sines();
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("decid-fitted-" + std::to_string(::getpid()) + ".csv");
  const sim::Simulator simulator(protocol);
  ReadOptions reading;
  reading.truth = protocol.parameters().middle();
  std::vector<double> sway(static_cast<std::size_t>(simulator.samples()));
  simulator.run(*reading.truth, Random(3, sim::streams::vestibular_noise, 0), sway);
  std::string csv = "time,com_sway_deg\n";
  for (std::size_t k = 0; k < sway.size(); ++k) {
    const double noise_deg = 0.02 * Random(3, sim::streams::sensor_noise, 0).normal(k);
    csv += format("%.2f,%.6f\n", 0.01 * static_cast<double>(k), sway[k] / sim::rad_per_deg + noise_deg);
  }
  write_file(file, csv);
  std::vector<RecordingResult> read = read_recordings(protocol, {file, "none/<b>.csv"}, reading);
  std::filesystem::remove(file);
  Fitter fitter(nullptr, protocol, {}, quick_request());
  fitter.fit(read);
  read.push_back(read.front());
  Report all = fitter.report();
  all.recordings = std::move(read);
  all.network_answers = true;
  all.recordings[0].file = "recordings/subject-04/trial-2.csv";
  FitFigures& first = *all.recordings[0].fit;
  first.compared = posterior::ComparedModel{.log_density = -100.0, .weight = 0.9};
  first.others.push_back({"dec",
                          first.posterior,
                          first.inferred.sway_rad,
                          first.check,
                          {.log_density = -110.0, .difference = -10.0, .standard_error = 3.0, .weight = 0.1},
                          {}});
  RecordingResult& odd = all.recordings[2];
  odd.file = hostile_name;
  odd.truth.reset();
  odd.warnings = {{Severity::caution, "chains_disagree", "the chains do not agree"}};
  odd.fit->answer = FitFigures::Answer::network;
  return all;
}

}  // namespace decid::test
