// The page of a fit: its content, its escaping of text from outside, its size, and that its bytes are reproducible.
// tests/tools/report/report_chromium.sh tests that its script draws.
#include "tools/report/fit_page.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/version.hpp"
#include "tests/near.hpp"
#include "tests/tools/report/fitted.hpp"
#include "tests/tools/report/page_text.hpp"
#include "tools/report/json/report_json.hpp"

namespace {

using namespace decid;
using posterior::Posterior;
using test::block_of;
using test::count;
using test::near;
using test::within;
using json = nlohmann::json;

constexpr double six_digits = 5e-6;  // of a number that begins with 1

const Report& fitted() {
  static const Report all = test::fitted_recordings();
  return all;
}

std::string page_of(const Report& all) {
  return tools::fit_page(all);
}

const json& data() {
  static const json parsed = test::data_of(page_of(fitted()));
  return parsed;
}

}  // namespace

// One case, because CTest starts a process for each, and each process would fit the recordings again.
TEST_CASE("fit page") {
  SUBCASE("whole, self-contained, small, and the same again") {
    const std::string page = page_of(fitted());
    test::check_whole(page);
    CHECK(page.find("prefers-color-scheme: dark") != std::string::npos);
    CHECK(page.size() < 192'000);  // two recordings of 30 s
    CHECK(page == page_of(fitted()));
  }
  SUBCASE("text from outside cannot leave its block") {
    const std::string page = page_of(fitted());
    CHECK(count(page, "</script>") == 4);  // two of them are the recordings'
    CHECK(block_of(page).find('<') == std::string::npos);
    REQUIRE(data()["recordings"].size() == 2);
    CHECK(data()["recordings"][1]["file"] == test::hostile_name);
    REQUIRE(data()["failed"].size() == 1);
    CHECK(data()["failed"][0].get<std::string>().find("none/<b>.csv") != std::string::npos);
  }
  SUBCASE("the figures are the posterior's") {
    const json& shown = data()["recordings"][0];
    const FitFigures& fit = *fitted().recordings[0].fit;
    const Posterior& found = fit.posterior;
    CHECK(data()["version"] == version);
    CHECK(data()["seed"] == 5);
    CHECK(data()["other_answer"]["command"] == "decid identify");
    CHECK(shown["answer"] == "posterior");
    CHECK(data()["recordings"][1]["answer"] == "network");
    CHECK(data()["recordings"][1]["warnings"][0]["code"] == "chains_disagree");
    const sim::ParameterTable& table = fitted().protocol.parameters();
    REQUIRE(shown["parameters"].size() == table.size());
    for (std::size_t p = 0; p < table.size(); ++p) {
      const json& parameter = shown["parameters"][p];
      const int quantity = static_cast<int>(p);
      CHECK(parameter["name"] == table[p].name);
      CHECK(near(parameter["mean"].get<double>(), found.mean(quantity), six_digits));
      CHECK(near(parameter["sd"].get<double>(), found.stddev(quantity), six_digits));
      CHECK(near(parameter["interval90"][1].get<double>(), found.quantile(quantity, 0.95), six_digits));
      CHECK(near(parameter["interval50"][0].get<double>(), found.quantile(quantity, 0.25), six_digits));
      CHECK(parameter.contains("true"));
      CHECK_FALSE(data()["recordings"][1]["parameters"][p].contains("true"));
      for (std::size_t q = 0; q < p; ++q)
        CHECK(
            within(shown["correlations"][p][q].get<double>(), found.correlation(quantity, static_cast<int>(q)), 0.006));
    }
    REQUIRE(shown["others"].size() == 3);
    CHECK(shown["others"][0]["name"] == "Measurement noise");
    const double start_s = found.mean(posterior::Density::start);
    CHECK(near(shown["others"][1]["mean"].get<double>(), std::abs(start_s), six_digits));
    CHECK((shown["others"][1]["name"].get<std::string>().find("before") != std::string::npos) == (start_s < 0.0));
    CHECK(shown["others"][1]["interval90"][0] < shown["others"][1]["interval90"][1]);
    CHECK(shown["diagnostics"]["draws"] == found.draws());
    REQUIRE(shown["check"]["figures"].size() == fit.check.figures.size());
    CHECK(shown["check"]["figures"].size() == 8);
    CHECK(near(shown["log_density"]["value"].get<double>(), fit.inferred.left_out.log_density, six_digits));
  }
  SUBCASE("the controllers are compared, with their parameters in SI units") {
    const json& controllers = data()["recordings"][0]["controllers"];
    REQUIRE(controllers.size() == 2);
    CHECK(controllers[0]["difference"] == 0.0);
    CHECK(controllers[1]["difference"] == -10.0);
    CHECK(controllers[1]["standard_error"] == 3.0);
    CHECK(controllers[1]["comparable"] == true);
    const Posterior& found = fitted().recordings[0].fit->posterior;
    const json& delay = controllers[1]["parameters"][sim::Delay];
    CHECK(delay["unit"] == "s");
    CHECK(near(delay["mean"].get<double>(), found.mean(sim::Delay), six_digits));
    CHECK(near(delay["high"].get<double>(), found.quantile(sim::Delay, 0.95), six_digits));
    CHECK(near(delay["sd"].get<double>(), found.stddev(sim::Delay), six_digits));
    CHECK(within(controllers[1]["correlations"][sim::Delay][sim::Kp].get<double>(),
                 found.correlation(sim::Delay, sim::Kp), 0.6e-4));
    CHECK(controllers[1]["warnings"].empty());
    CHECK(data()["recordings"][1]["controllers"].empty());
  }
  SUBCASE("the controllers have the recorded response, and the bands of their simulated trials") {
    const RecordingResult& first = fitted().recordings[0];
    const FrequencyResponses& frf = *first.explanation.frf;
    for (const json& controller : data()["recordings"][0]["controllers"]) {
      const json& shown = controller["frf"];
      for (const char* key : {"frequency_hz", "gain", "phase_deg", "model_gain", "model_phase_deg",
                              "model_gain_interval90", "model_phase_interval90"})
        REQUIRE(shown[key].size() == 2);  // three sines
      for (std::size_t i = 0; i < 2; ++i) {
        CHECK(near(shown["frequency_hz"][i].get<double>(), frf.recorded[i].frequency_hz, six_digits));
        CHECK(near(shown["gain"][i].get<double>(), std::abs(first.fit->check.responses.recorded[i].response),
                   six_digits));
        CHECK(near(shown["gain"][i].get<double>(), std::abs(frf.recorded[i].response), 0.05));  // with its line
        for (const bool is_gain : {true, false}) {
          const json& interval = shown[is_gain ? "model_gain_interval90" : "model_phase_interval90"][i];
          const json& middle = shown[is_gain ? "model_gain" : "model_phase_deg"][i];
          CHECK(interval[0] < middle);
          CHECK(middle < interval[1]);
        }
        // The response of the posterior mean, without noise.
        const double model_gain = std::abs(frf.model[i].response);
        CHECK(shown["model_gain_interval90"][i][0] < model_gain);
        CHECK(shown["model_gain_interval90"][i][1] > model_gain);
        const double turned_deg =
            std::arg(frf.model[i].response) / sim::rad_per_deg - shown["model_phase_deg"][i].get<double>();
        CHECK(std::abs(turned_deg - 360.0 * std::round(turned_deg / 360.0)) < 30.0);
        CHECK(std::abs(shown["phase_deg"][i].get<double>() - shown["model_phase_deg"][i].get<double>()) < 180.0);
      }
    }
    Report all = fitted();
    all.recordings[0].fit->check.responses = {};
    all.recordings[0].fit->others[0].warnings = {{Severity::caution, "divergences", "many"}};
    const json changed = test::data_of(page_of(all))["recordings"][0]["controllers"];
    CHECK(changed[0]["frf"].is_null());
    CHECK(changed[1]["frf"].is_object());
    CHECK(changed[1]["warnings"][0]["code"] == "divergences");
  }
  SUBCASE("the JSON sums the controllers over the recordings") {
    Report all = fitted();
    CHECK_FALSE(json::parse(tools::report_json(all)).contains("controller_comparison"));  // of one recording
    FitFigures& last = *all.recordings[2].fit;
    last.others = all.recordings[0].fit->others;
    last.compared = {.log_density = -90.0, .difference = -4.0, .standard_error = 1.0, .weight = 0.2};
    last.others[0].compared = {.log_density = -86.0, .weight = 0.8};
    const json sums = json::parse(tools::report_json(all))["controller_comparison"];
    CHECK(sums["not_comparable"] == 0);
    CHECK(sums["not_usable"] == 0);
    last.others[0].comparable = false;
    add_invalid(all.recordings[2].warnings, "does_not_stand", "one");
    const json spoilt = json::parse(tools::report_json(all));
    CHECK(spoilt["controller_comparison"]["not_comparable"] == 1);
    CHECK(spoilt["controller_comparison"]["not_usable"] == 1);
    CHECK(spoilt["recordings"][2]["controllers"][0]["comparable"] == true);
    CHECK(spoilt["recordings"][2]["controllers"][1]["comparable"] == false);
    REQUIRE(sums["controllers"].size() == 2);
    const json &first = sums["controllers"][0], &second = sums["controllers"][1];
    CHECK(first["controller"] == "dec");
    CHECK(first["best_in"] == 1);
    CHECK(first["log_predictive_density"] == -190.0);
    CHECK(second["difference"] == -6.0);
    CHECK(near(second["difference_standard_error"].get<double>(), std::sqrt(10.0), 1e-14));
  }
  SUBCASE("draws and ranks are those of the chains") {
    const json& shown = data()["recordings"][0];
    const Posterior& found = fitted().recordings[0].fit->posterior;
    const json& draws = shown["draws"];
    const std::size_t each = draws["each"], chains = draws["chains"], every = draws["every"];
    CHECK(chains == 8);
    CHECK(each * every == 40);
    const sim::ParameterTable& table = fitted().protocol.parameters();
    for (std::size_t p = 0; p < table.size(); ++p) {
      REQUIRE(draws["values"][p].size() == chains * each);
      for (std::size_t chain = 0; chain < chains; ++chain) {
        for (std::size_t i = 0; i < each; ++i) {
          const double low = draws["low"][p], high = draws["high"][p];
          const double part = draws["values"][p][chain * each + i].get<double>() / draws["range"].get<double>();
          const double value = found.states()[chain * 40 + (i + 1) * every - 1].parameters[p];
          REQUIRE(within(low + part * (high - low), value, 0.51 / 9999.0 * (high - low)));
        }
      }
      std::vector<int> bins(10, 0);
      for (const json& chain : shown["ranks"][p]) {
        int sum = 0;
        for (std::size_t bin = 0; bin < 10; ++bin) sum += chain[bin].get<int>(), bins[bin] += chain[bin].get<int>();
        CHECK(sum == 40);
      }
      for (const int bin : bins) CHECK(bin == 32);
    }
  }
  SUBCASE("what is shown over time keeps a thousandth of its width") {
    const json& signals = data()["recordings"][0]["signals"];
    const posterior::Inferred& inferred = fitted().recordings[0].fit->inferred;
    const auto check_chart = [](const json& chart, const char* name, const std::vector<double>& values_rad,
                                double offset) {
      const double per_degree = chart["per_degree"];
      REQUIRE(chart[name].size() == values_rad.size());
      for (std::size_t i = 0; i < values_rad.size(); ++i) {
        const double expected = (values_rad[i] - offset) / sim::rad_per_deg;
        REQUIRE(within(chart[name][i].get<double>() / per_degree, expected, 0.501 / per_degree));
      }
    };
    double mean = 0.0;
    for (const double value : inferred.sway_rad.middle) mean += value / 300.0;
    check_chart(signals["sway"], "model_low", inferred.sway_rad.low, mean);
    check_chart(signals["sway"], "model_high", inferred.sway_rad.high, mean);
    CHECK(signals["sway"]["recorded"].size() == 300);
    CHECK(signals["sway"]["again_high"].size() == 300);
    CHECK(near(signals["sway"]["first_s"].get<double>(), 0.045, 1e-12));
    CHECK(near(signals["noise"]["step_s"].get<double>(), 0.1, 1e-12));
    const std::vector<double>& estimate = inferred.tilt_estimate_rad.middle;
    check_chart(signals["tilt"], "estimate_middle", estimate, 0.0);
    CHECK(signals["tilt"]["platform"].size() == estimate.size());
  }
  SUBCASE("the recorded sway is the one before a low-pass that was undone") {
    Report all = fitted();
    RecordingResult& first = all.recordings[0];
    const auto shown = [&] { return test::data_of(page_of(all))["recordings"][0]["signals"]["sway"]; };
    const json as_recorded = shown();
    first.trial.low_pass = {1, true, 3.0, 100.0, 0.5, 0.9};  // unclear: it was not undone
    CHECK(shown() == as_recorded);
    first.trial.low_pass->gain_low = first.trial.low_pass->gain_high = 0.59;
    const json undone = shown();
    CHECK(undone["recorded"] != as_recorded["recorded"]);
    first.trial.sway_rad() = undo(*first.trial.low_pass, first.trial.sway_rad(), 100.0);
    first.trial.low_pass.reset();
    CHECK(shown() == undone);
  }
  SUBCASE("without trials that stand there is no band of them") {
    Report all = fitted();
    all.recordings[0].fit->check = {};
    all.recordings[0].fit->check.standing = 12;
    const json shown = test::data_of(page_of(all))["recordings"][0];
    CHECK(shown["check"]["figures"].empty());
    CHECK(shown["check"]["standing"] == 12);
    CHECK_FALSE(shown["signals"]["sway"].contains("again_low"));
  }
}
