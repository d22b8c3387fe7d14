// Writes a report of made-up recordings, for looking at and for report_chromium.sh:
//   report_sample PAGE.html [several|folded|one|many|fit|dataset]
// One simulated trial with known parameters, one whose fit fell over and one with an odd name; "folded": with
// densities; "one": the first of these; "many": sixty of them, in two groups; "fit": the report of fits; "dataset": of
// a data set.
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/math/random.hpp"
#include "dataset/image/image.hpp"
#include "identify/explanation.hpp"
#include "sim/simulate.hpp"
#include "sim/streams.hpp"
#include "tests/tools/report/fitted.hpp"
#include "tools/report/dataset_page.hpp"
#include "tools/report/fit_page.hpp"
#include "tools/report/identify_page.hpp"

namespace {

using decid::RecordingResult;
using decid::Report;
using decid::tools::identify_page;
namespace sim = decid::sim;

std::vector<float> run(const sim::Simulator& simulator, const sim::Parameters& parameters) {
  std::vector<double> sway_rad(static_cast<std::size_t>(simulator.samples()));
  simulator.run(parameters, decid::Random(7, decid::sim::streams::vestibular_noise, 0), sway_rad);
  return {sway_rad.begin(), sway_rad.end()};
}

/// Returns a report without recordings, with the settings that all recordings of a page share.
Report nothing_yet(const sim::Simulator& simulator, std::vector<decid::dataset::Channel> channels, int fold) {
  const decid::Explainer explainer(simulator);
  Report all;
  all.model = "built-in";
  all.model_sha256 = std::string(64, 'a');
  all.protocol = simulator.protocol();
  all.tilt_rad.assign(explainer.tilt_rad().begin(), explainer.tilt_rad().end());
  all.image.channels = std::move(channels);
  all.image.fold = fold;
  all.image_shape = decid::dataset::ImageMaker(all.image, simulator.samples()).shape();
  return all;
}

RecordingResult recording(const sim::Simulator& simulator, const Report& of) {
  RecordingResult made;
  made.file = "recordings/subject-04/trial-2.csv";
  made.column = "com_sway_deg";
  made.truth = sim::Parameters{790.0, 265.0, 171.0, 118.0, 0.62, 0.0017, 0.121};
  made.estimate.parameters = {823.4, 251.9, 183.2, 124.6, 0.57, 0.0021, 0.114};
  made.trial = decid::recording::make_trial(run(simulator, *made.truth));
  made.explanation = decid::Explainer(simulator).explain({made.estimate.parameters, made.trial});
  made.explanation.warnings.clear();
  made.explanation.rms_residual_deg = 0.2874;
  made.explanation.variance_accounted_for = 0.631;
  made.estimate.image.resize(static_cast<std::size_t>(of.image_shape.size()));
  decid::dataset::ImageMaker(of.image, simulator.samples()).make(made.trial.sway_rad(), made.estimate.image);
  return made;
}

Report several(std::vector<decid::dataset::Channel> channels, int fold = 1) {
  const sim::Simulator simulator(sim::default_protocol());
  Report all = nothing_yet(simulator, std::move(channels), fold);
  RecordingResult fallen = recording(simulator, all);
  fallen.file = "recordings/subject-05/trial-1.csv";
  fallen.truth.reset();
  fallen.estimate.parameters[sim::Delay] = 0.262;
  fallen.explanation.fitted_rad.resize(3417);
  fallen.explanation.frf->model.clear();
  fallen.explanation.rms_residual_deg = fallen.explanation.variance_accounted_for =
      std::numeric_limits<double>::quiet_NaN();
  using decid::Severity;
  fallen.warnings = {
      {Severity::caution, "outside_range", "delay is outside the range the model was trained on; do not rely on it"},
      {Severity::invalid, "does_not_stand",
       "the body simulated from the identified parameters fell over after 34.2 s"}};
  RecordingResult odd = recording(simulator, all);
  odd.file = "</script><script>document.body.dataset.error='markup'</script>.csv";
  RecordingResult failed;
  failed.error = decid::Error(decid::Code::value_missing, "recordings/<b>subject-06</b>.csv",
                              "line 3, sway: the cell is empty", "give a value");
  all.recordings = {recording(simulator, all), failed, fallen, odd};
  return all;
}

/// Returns the report with a distribution for every recording: most parameters are known well, two gains only in
/// combination.
Report sure(Report all) {
  const std::size_t parameters = all.protocol.parameters().size();
  std::vector<double> outputs(decid::mixture_outputs(1, parameters), 0.0);
  for (std::size_t p = 0; p < parameters; ++p) {
    outputs[1 + p] = 0.3 - 0.1 * static_cast<double>(p);
    outputs[1 + parameters + p] = 0.4 * static_cast<double>(p);
  }
  outputs[1 + 2 * parameters] = 1.2;
  for (RecordingResult& made : all.recordings)
    if (!made.error)
      made.estimate.distribution.emplace(decid::Mixture(1, parameters, outputs), all.protocol.parameters());
  return all;
}

std::string dataset_page() {
  decid::tools::DatasetFigures figures;
  figures.file = "</script><script>document.body.dataset.error='markup'</script>.npz";
  figures.version = "0.1.0";
  figures.request = {sim::short_protocol(), 120, 90, 1};
  figures.request.protocol.sequence().amplitude_deg = 4.0;  // so that some are parents
  decid::dataset::generate(figures.request, &figures.report);
  figures.bytes = 3'100'000;
  return dataset_html(figures);
}

/// Returns a page of sixty recordings in two groups. Every fifth recording is not usable.
std::string page_of_many(Report all) {
  const RecordingResult first = all.recordings.front();
  decid::GroupTable table{"subject", {}};
  all.recordings.clear();
  for (int i = 0; i < 60; ++i) {
    RecordingResult& made = all.recordings.emplace_back(first);
    made.file = "recordings/subject-" + std::to_string(i + 1) + ".csv";
    made.truth.reset();
    for (double& value : made.estimate.parameters) value *= 0.8 + 0.006 * i;
    if (i % 5 == 4) made.warnings = {{decid::Severity::invalid, "out_of_distribution", "it looks like no trial"}};
    table.members.push_back({i % 2 == 0 ? "patients" : "controls", std::to_string(i < 48 ? i / 2 : i)});
  }
  all.groups = decid::report_groups(table, all);
  return identify_page(all);
}

/// Returns a page of two groups in two sessions, with ages.
std::string page_of_sessions(Report all) {
  const RecordingResult first = all.recordings.front();
  decid::GroupTable table{"participant_id", {}};
  table.covariates = {"age"};
  all.recordings.clear();
  for (int i = 0; i < 24; ++i) {
    RecordingResult& made = all.recordings.emplace_back(first);
    made.file = "recordings/" + std::to_string(i + 1) + ".csv";
    for (double& value : made.estimate.parameters) value *= 0.8 + 0.01 * i;
    table.members.push_back({i % 2 == 0 ? "patients" : "controls",
                             std::to_string(i / 4 * 2 + i % 2),
                             i / 2 % 2 == 0 ? "before" : "after",
                             "",
                             {40.0 + i / 4}});
  }
  all.groups = decid::report_groups(table, all);
  return identify_page(all);
}

std::string page_of(const std::string& kind) {
  using decid::dataset::Channel;
  if (kind == "dataset") return dataset_page();
  if (kind == "fit") return decid::tools::fit_page(decid::test::fitted_recordings());
  const std::vector<Channel> folded{Channel::asinh_real, Channel::asinh_imaginary, Channel::log_residual};
  if (kind == "folded") return identify_page(sure(several(folded, 2)));
  if (kind == "many") return page_of_many(sure(several(folded, 2)));
  if (kind == "sessions") return page_of_sessions(sure(several(folded, 2)));
  if (kind == "one") {
    Report one = sure(several(folded, 2));
    one.recordings.resize(1);
    return identify_page(one);
  }
  return identify_page(
      several({Channel::modulus, Channel::phase, Channel::log_modulus, Channel::cos_phase, Channel::sin_phase}));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fputs("usage: report_sample PAGE.html [several|folded|one|many|fit|dataset]\n", stderr);
    return 2;
  }
  try {
    decid::write_file(argv[1], page_of(argc > 2 ? argv[2] : ""));
    return 0;
  } catch (const decid::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
