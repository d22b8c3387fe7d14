// The report page: its content, its escaping of text from outside, its size, and that its bytes are reproducible.
// tests/tools/report/report_chromium.sh tests that its script draws.
#include "tools/report/identify_page.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/version.hpp"
#include "tests/near.hpp"
#include "tests/tools/report/page_text.hpp"

namespace {

using decid::RecordingResult;
using decid::Report;
using decid::test::block_of;
using decid::test::count;
using decid::test::near;
using decid::tools::identify_page;
using json = nlohmann::json;
namespace sim = decid::sim;

/// The largest relative change by rounding to six significant digits, for a number that begins with 1.
constexpr double six_digits = 5e-6;
constexpr float nan_float = std::numeric_limits<float>::quiet_NaN();
constexpr double nan_double = std::numeric_limits<double>::quiet_NaN();

Report recording() {
  Report all;
  all.model = "built-in";
  all.model_sha256 = "0123abcd";
  RecordingResult& made = all.recordings.emplace_back();
  made.file = "trial.csv";
  made.column = "com_sway_deg";
  made.estimate.parameters = sim::single_pendulum().parameters.middle();
  made.estimate.parameters[sim::Kp] = 838.99;
  made.explanation.rms_residual_deg = 0.25;
  made.explanation.variance_accounted_for = 0.75;
  made.trial = decid::recording::make_trial({});
  for (int k = 0; k < 12100; ++k) {
    const double phase = 2.0 * sim::pi * k / 1000.0;
    made.trial.sway_rad().push_back(static_cast<float>(sim::rad_per_deg * std::sin(phase)));
    made.explanation.fitted_rad.push_back(static_cast<float>(0.9 * sim::rad_per_deg * std::sin(phase)));
    all.tilt_rad.push_back(static_cast<float>(0.5 * sim::rad_per_deg * std::cos(phase)));
  }
  all.image_shape = {2, 110, 110};
  for (int i = 0; i < all.image_shape.size(); ++i) {
    made.estimate.image.push_back(static_cast<float>(3.0 * std::sin(0.37 * i) * std::exp(-0.0005 * (i % 12100))));
  }
  return all;
}

json data_of(const Report& all) {
  return decid::test::data_of(identify_page(all));
}

}  // namespace

TEST_CASE("the page is whole, self-contained and small") {
  const std::string page = identify_page(recording());
  decid::test::check_whole(page);
  CHECK(page.find("default-src 'none'") != std::string::npos);
  CHECK(count(page, "</script>") == 3);
  CHECK(page.size() < 500'000);
}

TEST_CASE("the data are those of the identification") {
  Report all = recording();
  RecordingResult& made = all.recordings.front();
  made.truth = sim::single_pendulum().parameters.middle();
  made.warnings = {{decid::Severity::caution, "samples_lacking", "the recording is short"},
                   {decid::Severity::info, "resampled", "from 50 Hz"}};
  const json data = data_of(all);
  CHECK(data["model"]["name"] == "built-in");
  CHECK(data["model"]["sha256"] == "0123abcd");
  CHECK(data["model"]["version"] == decid::version);
  const json& shown = data["recordings"][0];
  CHECK(shown["file"] == "trial.csv");
  CHECK(shown["column"] == "com_sway_deg");
  CHECK(shown["trust"] == "caution");
  CHECK(shown["warnings"][0] ==
        json{{"code", "samples_lacking"}, {"severity", "caution"}, {"text", "the recording is short"}});
  CHECK(shown["warnings"][1]["severity"] == "info");
  CHECK(shown["rms_residual_deg"] == 0.25);
  CHECK(shown["variance_accounted_for"] == 0.75);
  CHECK(shown["protocol"]["duration_s"] == 121.0);
  CHECK(shown["protocol"]["cycle_s"] == 60.5);
  REQUIRE(shown["parameters"].size() == 7);
  for (std::size_t i = 0; i < 7; ++i) {
    const json& parameter = shown["parameters"][i];
    CAPTURE(i);
    CHECK(parameter["name"] == sim::single_pendulum().parameters[i].name);
    CHECK(near(parameter["value"].get<double>(), made.estimate.parameters[i], six_digits));
    CHECK(near(parameter["true"].get<double>(), (*made.truth)[i], six_digits));
    CHECK(parameter["normalized"].is_number() == sim::single_pendulum().parameters[i].scales_with_mgh);
  }
  CHECK(near(shown["parameters"][0]["normalized"].get<double>(), 838.99 / sim::Body{}.mgh(), six_digits));
}

TEST_CASE("a value is marked as outside of its range where the warnings name it, and nowhere else") {
  Report all = recording();
  const sim::ParameterInfo& kp = sim::single_pendulum().parameters[sim::Kp];
  for (const auto& [share, beyond] :
       {std::pair(-0.051, true), {-0.049, false}, {0.5, false}, {1.049, false}, {1.051, true}}) {
    all.recordings[0].estimate.parameters[sim::Kp] = kp.low + share * kp.range();
    const json shown = data_of(all)["recordings"][0]["parameters"];
    CHECK(shown[sim::Kp]["beyond"] == beyond);
    CHECK(shown[sim::Kd]["beyond"] == false);
  }
}

TEST_CASE("a network that says how sure it is: intervals, densities and correlations") {
  Report all = recording();
  CHECK_FALSE(data_of(all)["recordings"][0].contains("correlations"));
  CHECK_FALSE(data_of(all)["recordings"][0].contains("densities"));
  std::vector<double> outputs(decid::mixture_outputs(1, 7), 0.0);
  for (std::size_t p = 0; p < 7; ++p) {
    outputs[1 + p] = 0.2 * static_cast<double>(p) - 0.6;
    outputs[8 + p] = 0.5 * static_cast<double>(p);  // from what the range says to 20 times as sure
  }
  outputs[15] = -0.9;
  const sim::ParameterTable& table = sim::single_pendulum().parameters;
  all.recordings[0].estimate.distribution.emplace(decid::Mixture(1, 7, outputs), table);
  const decid::ParameterDistribution& found = *all.recordings[0].estimate.distribution;
  const json data = data_of(all), &shown = data["recordings"][0];
  CHECK(data["model"]["recalibrated"] == false);
  REQUIRE(shown["correlations"].size() == 7);
  REQUIRE(shown["correlations"][6].size() == 6);
  CHECK(std::abs(shown["correlations"][1][0].get<double>() - found.correlation(1, 0)) < 0.0051);
  for (std::size_t p = 0; p < 7; ++p) {
    const json& parameter = shown["parameters"][p];
    const int quantity = static_cast<int>(p);
    CHECK(near(parameter["mean"].get<double>(), found.mean(quantity), six_digits));
    CHECK(near(parameter["sd"].get<double>(), found.stddev(quantity), six_digits));
    CHECK(near(parameter["interval50"][0].get<double>(), found.quantile(quantity, 0.25), six_digits));
    CHECK(near(parameter["interval90"][1].get<double>(), found.quantile(quantity, 0.95), six_digits));
    const json& density = shown["densities"][p];
    double whole = 0.0;
    for (std::size_t i = 1; i < density.size(); ++i) {
      const double width = density[i][0].get<double>() - density[i - 1][0].get<double>();
      REQUIRE(width >= 0.0);
      whole += 0.5 * width * (density[i][1].get<double>() + density[i - 1][1].get<double>());
    }
    // Trapezoids err at the ends, where a density may rise without limit: within a hundredth of the range the first
    // one's goes from 3.4 to 7.7, of which the straight line has 0.055 and a power of the place 0.04.
    CHECK(std::abs(whole - 1.0) < 0.02);
  }
}

TEST_CASE("curves keep a thousandth of their width") {
  const Report all = recording();
  const RecordingResult& made = all.recordings.front();
  const json series = data_of(all)["recordings"][0]["series"];
  const double per_degree = series["per_degree"];
  CHECK(1.0 / per_degree <= 2.0 / 1000);
  REQUIRE(series["sway"].size() == made.trial.sway_rad().size());
  double sum = 0.0;  // of steps
  for (std::size_t k = 0; k < made.trial.sway_rad().size(); ++k) {
    sum += series["sway"][k].get<double>();
    const double shown_deg = sum / per_degree;
    REQUIRE(std::abs(shown_deg - made.trial.sway_rad()[k] / sim::rad_per_deg) <= 0.5001 / per_degree);
  }
}

TEST_CASE("a recording without movement, or of one sample, or of none makes a page") {
  Report all = recording();
  RecordingResult& still = all.recordings.front();
  for (std::vector<float>* signal : {&still.trial.sway_rad(), &still.explanation.fitted_rad, &all.tilt_rad})
    signal->assign(12100, 0.0F);
  CHECK(data_of(all)["recordings"][0]["series"]["sway"][5] == 0);
  still.trial.sway_rad().resize(1);
  still.explanation.fitted_rad.clear();
  CHECK(data_of(all)["recordings"][0]["series"]["fitted"].empty());
  still.trial.sway_rad().clear();
  all.tilt_rad.clear();
  still.estimate.image.clear();
  CHECK(data_of(all)["recordings"][0]["image"].is_null());
  CHECK(json::parse(block_of(identify_page({})))["recordings"].empty());
}

TEST_CASE("the image keeps the rows below half the sample rate and its limits") {
  Report all = recording();
  RecordingResult& made = all.recordings.front();
  made.estimate.image[3] = nan_float;
  const json image = data_of(all)["recordings"][0]["image"];
  CHECK(image["rows"] == 56);
  CHECK(image["columns"] == 110);
  CHECK(image["mirrored"] == true);
  CHECK(image["column_s"] == 1.1);
  REQUIRE(image["channels"].size() == 2);
  const json& modulus = image["channels"][0];
  CHECK(modulus["name"] == "modulus");
  REQUIRE(modulus["levels"].size() == 56 * 110);
  CHECK(modulus["levels"][3].is_null());
  for (const json& level : modulus["levels"]) {
    if (!level.is_null()) REQUIRE((level >= 0 && level <= 255));
  }
  CHECK(image["channels"][1]["kind"] == "cyclic");
  CHECK(near(image["channels"][1]["low"].get<double>(), -sim::pi, six_digits));
  made.estimate.image.pop_back();
  CHECK_THROWS_AS(identify_page(all), decid::Error);
}

TEST_CASE("what is not a number becomes null") {
  Report all = recording();
  RecordingResult& made = all.recordings.front();
  made.explanation.rms_residual_deg = nan_double;
  made.explanation.variance_accounted_for = -std::numeric_limits<double>::infinity();
  made.estimate.parameters[sim::Kd] = nan_double;
  made.trial.sway_rad()[17] = nan_float;
  made.explanation.fitted_rad.resize(100);
  const json shown = data_of(all)["recordings"][0];
  CHECK(shown["rms_residual_deg"].is_null());
  CHECK(shown["variance_accounted_for"].is_null());
  CHECK(shown["peak_to_peak_deg"].is_null());
  CHECK(shown["parameters"][1]["value"].is_null());
  CHECK(shown["parameters"][1]["normalized"].is_null());
  CHECK(shown["series"]["sway"][17].is_null());
  CHECK(shown["series"]["fitted"].size() == 100);
}

TEST_CASE("text from outside cannot leave its block") {
  const std::string hostile = "</script><script>alert(1)</script><!--<script>{{page_js}}&amp;\" \\u003c\xff\x01";
  Report all = recording();
  RecordingResult& made = all.recordings.front();
  made.file = made.column = hostile;
  all.protocol.name = hostile;
  made.warnings = {{decid::Severity::caution, "hostile", hostile}};
  all.model = all.model_sha256 = hostile;
  all.options = {hostile};
  const std::string page = identify_page(all);
  CHECK(count(page, "</script>") == 3);
  CHECK(page.find("<script>alert") == std::string::npos);
  for (const char* block : {"report-data", "details-1"}) CHECK(block_of(page, block).find('<') == std::string::npos);
  const json data = decid::test::data_of(page);
  // As it was, but for the byte that is not UTF-8.
  const std::string kept = "</script><script>alert(1)</script><!--<script>{{page_js}}&amp;\" \\u003c\xef\xbf\xbd\x01";
  CHECK(data["recordings"][0]["file"] == kept);
  CHECK(data["recordings"][0]["warnings"][0]["text"] == kept);
  CHECK(data["model"]["name"] == kept);
}
