// Writes a report of made-up recordings, for looking at and for report_chromium.sh:
//   report_sample PAGE.html [several|dataset]
// One simulated trial with known parameters; "several" adds one whose fit fell over and one with an odd name;
// "dataset": the report of a data set.
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/file.hpp"
#include "base/random.hpp"
#include "dataset/image/image.hpp"
#include "identify/frequency_response.hpp"
#include "sim/simulate.hpp"
#include "tools/report/dataset_page.hpp"
#include "tools/report/frf.hpp"
#include "tools/report/identify_page.hpp"

namespace {

using decid::Identification;
namespace sim = decid::sim;

std::vector<float> run(const sim::Simulator& simulator, const sim::Parameters& parameters) {
  std::vector<double> sway_rad(static_cast<std::size_t>(simulator.samples()));
  simulator.run(parameters, decid::Random(7, decid::Stream::vestibular_noise, 0), sway_rad);
  return {sway_rad.begin(), sway_rad.end()};
}

Identification recording(std::vector<decid::dataset::Channel> channels, int fold = 1) {
  const sim::Simulator simulator(sim::default_protocol());
  Identification made;
  made.file = "recordings/subject-04/trial-2.csv";
  made.column = "com_sway_deg";
  made.protocol = simulator.protocol();
  made.truth = sim::Parameters{790.0, 265.0, 171.0, 118.0, 0.62, 0.0017, 0.121};
  made.parameters = {823.4, 251.9, 183.2, 124.6, 0.57, 0.0021, 0.114};
  made.sway_rad = run(simulator, *made.truth);
  sim::Parameters noise_free = made.parameters;
  noise_free[sim::Nv] = 0.0;
  made.fitted_rad = run(simulator, noise_free);
  for (int k = 0; k < simulator.samples(); ++k) {
    const int step = k * simulator.protocol().steps_per_sample();
    made.tilt_rad.push_back(static_cast<float>(simulator.stimulus().tilt_at(step)));
  }
  decid::add_frequency_response(made);
  made.rms_residual_deg = 0.2874;
  made.variance_accounted_for = 0.631;
  made.peak_to_peak_deg = 2.148;
  made.image_settings.channels = std::move(channels);
  made.image_settings.fold = fold;
  const decid::dataset::ImageMaker maker(made.image_settings, simulator.samples());
  made.image_shape = maker.shape();
  made.image.resize(static_cast<std::size_t>(made.image_shape.size()));
  maker.make(made.sway_rad, made.image);
  return made;
}

std::vector<Identification> several() {
  using decid::dataset::Channel;
  Identification fallen = recording({Channel::log_modulus, Channel::cos_phase, Channel::sin_phase});
  fallen.file = "recordings/subject-05/trial-1.csv";
  fallen.truth.reset();
  fallen.fitted_rad.resize(3417);
  fallen.rms_residual_deg = fallen.variance_accounted_for = std::numeric_limits<double>::quiet_NaN();
  fallen.parameters[sim::Delay] = 0.262;
  fallen.warnings = {"delay is outside the range the model was trained on; do not rely on it",
                     "the body simulated from the identified parameters fell over after 34.2 s"};
  decid::add_frequency_response(fallen);
  Identification odd = recording({Channel::asinh_real, Channel::asinh_imaginary, Channel::log_residual}, 2);
  odd.file = "</script><script>document.body.dataset.error='markup'</script>.csv";
  Identification failed;
  failed.error = decid::Error("recordings/<b>subject-06</b>.csv", "line 3, sway: the cell is empty", "give a value");
  return {recording({Channel::modulus, Channel::phase}), failed, fallen, odd};
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

std::string page_of(const std::string& kind) {
  using decid::dataset::Channel;
  if (kind == "dataset") return dataset_page();
  const decid::tools::ReportModel model{"built-in", std::string(64, 'a'), "0.1.0"};
  return report_html(model, kind == "several" ? several() : std::vector{recording({Channel::modulus, Channel::phase})});
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fputs("usage: report_sample PAGE.html [several|dataset]\n", stderr);
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
