// Predictive checks: their p-values are uniform where the recording is one of the draws', and small where it is another
// person's, noise, scaled, reversed, or has one odd cycle.
#include "identify/predictive_check.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>

#include "identify/explanation.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"
#include "tests/sim/sines.hpp"

namespace decid {
namespace {

using posterior::State;
using namespace test;

const sim::Simulator& simulator() {
  static const sim::Simulator one(test::three_sines());
  return one;
}
const PredictiveChecker& checker() {
  static const PredictiveChecker one(simulator(), 0.1);
  return one;
}

State state(double nv = 0.3) {
  State made{.parameters = sim::single_pendulum().parameters.middle(), .sensor_noise_deg = 0.02};
  made.parameters[sim::Nv] = nv;
  return made;
}

/// Draws that differ in everything.
std::vector<State> draws() {
  const Random random(4, sim::streams::base_parameters, 0);
  std::vector<State> made;
  for (std::uint64_t i = 0; i < 40; ++i) {
    std::vector<double> unit;
    for (std::uint64_t p = 0; p < 7; ++p) unit.push_back(random.uniform(16 * i + p, 0.35, 0.65));
    made.push_back({.parameters = simulator().protocol().parameters().from_unit(unit),
                    .sensor_noise_deg = random.uniform(16 * i + 8, 0.01, 0.03),
                    .start_s = random.uniform(16 * i + 9, -0.1, 0.1),
                    .gain = random.uniform(16 * i + 10, 0.9, 1.1)});
  }
  return made;
}

/// A recording, with the start taken at a sample.
std::vector<float> recorded(const State& state, std::uint64_t item) {
  std::vector<double> sway(static_cast<std::size_t>(simulator().samples()));
  REQUIRE(simulator().run(state.parameters, Random(3, sim::streams::vestibular_noise, item), sway).valid);
  const Random sensor(3, sim::streams::sensor_noise, item);
  const auto shift = static_cast<std::ptrdiff_t>(std::lround(100.0 * state.start_s));
  std::vector<float> recording;
  for (std::ptrdiff_t k = 0; k < std::ssize(sway); ++k) {
    const auto from = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(k + shift, 0, std::ssize(sway) - 1));
    const double noise_rad = state.sensor_noise_deg * sim::rad_per_deg * sensor.normal(static_cast<std::uint64_t>(k));
    recording.push_back(static_cast<float>(state.gain * sway[from] + noise_rad));
  }
  return recording;
}

PredictiveCheck check(const std::vector<float>& sway, const std::vector<State>& from = {state()}) {
  return checker().check(from, recording::make_trial(sway), 1);
}

double p_of(const PredictiveCheck& check, const std::string& name) {
  const auto found = std::ranges::find(check.figures, name, &CheckedFigure::name);
  REQUIRE(found != check.figures.end());
  return found->p;
}

const std::vector<std::string> names{"0.05 to 0.2 Hz",     "0.2 to 0.5 Hz", "0.5 to 1 Hz",  "1 to 2.5 Hz",
                                     "frequency response", "level",         "largest sway", "between cycles"};

}  // namespace

// Each p is uniform, so the mean of 60 has a deviation of 0.037, and at most 0.08 of them cry out.
TEST_CASE("predictive check: p-values of recordings that are the draws' are uniform" * doctest::test_suite("slow")) {
  const std::vector<State> from = draws();
  constexpr int recordings = 60;
  std::map<std::string, double> sums;
  std::map<std::string, int> low;
  int warned = 0, gains_outside = 0, phases_outside = 0;
  for (int i = 0; i < recordings; ++i) {
    const std::size_t draw = static_cast<std::size_t>(7 * i) % from.size();
    const PredictiveCheck found = check(recorded(from[draw], static_cast<std::uint64_t>(i)), from);
    REQUIRE(found.figures.size() == names.size());
    warned += found.warning().empty() ? 0 : 1;
    for (std::size_t band = 0; band < found.responses.recorded.size(); ++band) {
      const sim::Complex response = found.responses.recorded[band].response;
      const posterior::Band &gain = found.responses.gain, &phase_rad = found.responses.phase_rad;
      gains_outside += std::abs(response) < gain.low[band] || std::abs(response) > gain.high[band] ? 1 : 0;
      const double phase = phase_rad.middle[band] + std::arg(response * std::polar(1.0, -phase_rad.middle[band]));
      phases_outside += phase < phase_rad.low[band] || phase > phase_rad.high[band] ? 1 : 0;
    }
    for (const CheckedFigure& figure : found.figures) {
      CHECK((figure.p > 0.0 && figure.p <= 1.0));
      sums[figure.name] += figure.p;
      low[figure.name] += figure.p <= 0.2 ? 1 : 0;
    }
  }
  for (const std::string& name : names) {
    CAPTURE(name);
    CHECK(test::within(sums[name] / recordings, 0.5, 4 * 0.037));
    CHECK((low[name] > 0 && low[name] < 12 + 4 * 3.1));  // 12 expected
  }
  // 12 of 120 expected, with a standard deviation of at most 4.7: a recording's two bands have its draw in common.
  CHECK((gains_outside > 0 && gains_outside < 12 + 4 * 4.7));
  CHECK((phases_outside > 0 && phases_outside < 12 + 4 * 4.7));
  CHECK(warned <= 13);  // 60 * 0.08 expected at most; more than 13 with a probability of 2e-4
}

// At most 0.08 of the recordings get a warning by chance, more than 2 of 6 with a probability of 9e-3.
TEST_CASE("predictive check: samples in gaps do not count, at an end either") {
  int warned = 0;
  for (std::uint64_t item = 0; item < 6; ++item) {
    std::vector<float> sway = recorded(state(), item);
    const std::vector<SampleRange> gaps{{0, 50}, {1000, 1500}, {sway.size() - 50, sway.size()}};
    for (const SampleRange& gap : gaps)
      for (std::size_t k = gap.first; k < gap.end; ++k) sway[k] = static_cast<float>(3.0 * sim::rad_per_deg);
    if (item == 0) CHECK(!check(sway).warning().empty());
    recording::Trial trial = recording::make_trial(sway);
    trial.gaps = gaps;
    const std::vector<State> from{state()};
    warned += checker().check(from, trial, 1).warning().empty() ? 0 : 1;
  }
  CHECK(warned <= 2);
}

TEST_CASE("predictive check: the bands of the response are around the controller's, and show a sway of another scale") {
  const sim::Experiment& experiment = simulator().protocol().experiment;
  const sim::FrequencyResponse analysis = frequency_analysis(experiment);
  std::vector<float> sway = recorded(state(), 1);
  const CheckedResponses found = check(sway).responses;
  REQUIRE(found.recorded.size() == 2);  // three sines
  REQUIRE(found.gain.middle.size() == 2);
  REQUIRE(found.phase_rad.middle.size() == 2);
  const std::vector<double> tilt_rad = sim::tilt_at_samples(experiment, simulator().stimulus());
  const std::vector<float> tilt(tilt_rad.begin(), tilt_rad.end());
  // Without noise: the response that the noise of the trials scatters about.
  const std::vector<sim::FrfPoint> exact = analysis.measure(noise_free_trial(simulator(), state().parameters), tilt);
  const std::vector<sim::FrfPoint> measured = analysis.measure(sway, tilt);
  for (std::size_t i = 0; i < 2; ++i) {
    CAPTURE(i);
    CHECK(found.recorded[i].frequency_hz == measured[i].frequency_hz);
    CHECK(std::abs(found.recorded[i].response - measured[i].response) < 0.05 * std::abs(measured[i].response));
    CHECK((found.gain.low[i] < found.gain.middle[i] && found.gain.middle[i] < found.gain.high[i]));
    const double gain = std::abs(exact[i].response);
    CHECK((found.gain.low[i] < gain && gain < found.gain.high[i]));
    const double turned_rad = std::arg(exact[i].response * std::polar(1.0, -found.phase_rad.middle[i]));
    CHECK(turned_rad > found.phase_rad.low[i] - found.phase_rad.middle[i]);
    CHECK(turned_rad < found.phase_rad.high[i] - found.phase_rad.middle[i]);
  }
  for (float& value : sway) value *= 3.0F;
  const CheckedResponses large = check(sway).responses;
  for (std::size_t i = 0; i < 2; ++i) CHECK(std::abs(large.recorded[i].response) > large.gain.high[i]);
  CHECK(large.gain.low == found.gain.low);  // of the same trials
}

TEST_CASE("predictive check: a recording unlike the draws has small p-values and a warning") {
  const std::vector<float> own = recorded(state(), 1);
  const PredictiveCheck usual = check(own);
  CHECK(usual.warning().empty());
  CHECK(usual.standing == PredictiveCheck::trials);
  REQUIRE(usual.figures.size() == names.size());
  for (std::size_t i = 0; i < names.size(); ++i) CHECK(usual.figures[i].name == names[i]);
  REQUIRE(usual.sway_rad.low.size() == 300);
  double mean = 0.0;
  for (const float value : own) mean += static_cast<double>(value) / 3000.0;
  int inside = 0;
  for (std::size_t k = 0; k < 3000; ++k) {
    const double value = static_cast<double>(own[k]) - mean;
    inside += usual.sway_rad.low[k / 10] <= value && value <= usual.sway_rad.high[k / 10] ? 1 : 0;
  }
  CHECK(inside > 1950);  // 2700 of a usual trial; what is outside lasts for a second

  SUBCASE("another person's, who sways more") {
    const PredictiveCheck found = check(recorded(state(1.0), 1));
    CHECK(p_of(found, "level") < PredictiveCheck::odd);
    CHECK(p_of(found, "between cycles") < PredictiveCheck::odd);
    CHECK(contains(found.warning(), "does not look like the recording"));
    CHECK(contains(found.warning(), "level "));
    CHECK(contains(found.warning(), "rms at 0.5 to 1 Hz"));
  }
  SUBCASE("scaled") {
    std::vector<float> scaled = own;
    for (float& value : scaled) value *= 4.0F;
    const PredictiveCheck found = check(scaled);
    CHECK(p_of(found, "level") < PredictiveCheck::odd);
    CHECK(p_of(found, "largest sway") < PredictiveCheck::odd);
    CHECK(p_of(found, "frequency response") < PredictiveCheck::odd);
  }
  SUBCASE("reversed: only the response shows it") {
    std::vector<float> reversed = own;
    for (float& value : reversed) value = -value;
    const PredictiveCheck found = check(reversed);
    CHECK(p_of(found, "frequency response") < PredictiveCheck::odd);
    CHECK(p_of(found, "level") == p_of(usual, "level"));
  }
  SUBCASE("white noise of the same level") {
    double squares = 0.0;
    for (const float value : own) squares += static_cast<double>(value * value) / 3000.0;
    std::vector<float> white;
    for (std::uint64_t k = 0; k < 3000; ++k)
      white.push_back(static_cast<float>(std::sqrt(squares) * Random(9, sim::streams::sensor_noise, 0).normal(k)));
    const PredictiveCheck found = check(white);
    CHECK(p_of(found, "1 to 2.5 Hz") < PredictiveCheck::odd);
    CHECK(p_of(found, "0.2 to 0.5 Hz") < PredictiveCheck::odd);
    CHECK(contains(found.warning(), "rms at 1 to 2.5 Hz"));
  }
  SUBCASE("one cycle unlike the others") {
    std::vector<float> odd = own;
    for (std::size_t k = 2000; k < 3000; ++k) odd[k] *= -3.0F;
    CHECK(p_of(check(odd), "between cycles") < PredictiveCheck::odd);
  }
}

TEST_CASE("predictive check: figures are right where they are known") {
  // A sine of one degree in the second band, 0.4 Hz, without noise.
  std::vector<float> sine;
  for (int k = 0; k < 3000; ++k)
    // About its middle a cosine is even: no straight line is along it.
    sine.push_back(static_cast<float>(sim::rad_per_deg * std::cos(2.0 * sim::pi * 0.4 * (k - 1499.5) / 100.0) + 0.01));
  const PredictiveCheck found = check(sine);
  const auto value = [&](std::size_t i) { return found.figures[i].recorded; };
  CHECK(near(value(1), std::sqrt(0.5), 1e-3));  // the window's leakage
  CHECK(value(2) < 0.01);
  // Means over blocks of ten samples.
  const double kept = std::sin(sim::pi * 0.04) / (10.0 * std::sin(sim::pi * 0.004));
  CHECK(near(value(5), kept * std::sqrt(0.5), 1e-6));
  CHECK(near(value(6), kept, 1e-5));
  CHECK(value(7) < 1e-6);  // four periods a cycle
  for (const CheckedFigure& figure : found.figures)
    CHECK((figure.low <= figure.middle && figure.middle <= figure.high));
  // The last two cycles are each other's negative: they deviate from their mean by the sine itself, divided by 2 - 1.
  std::vector<float> turned = sine;
  for (std::size_t k = 2000; k < 3000; ++k) turned[k] = 0.02F - turned[k];
  CHECK(near(check(turned).figures[7].recorded, kept, 5e-3));
}

TEST_CASE("predictive check: noise that a lower sample rate does not have is no sign") {
  // Every second sample of a body with little noise of its own, and means of its neighbours between: the noise of the
  // measurement is as large at low frequencies as that of the draw, and smaller above 25 Hz.
  State draw = state(0.0);
  draw.sensor_noise_deg = 0.03;
  std::vector<float> slower = recorded(draw, 1);
  for (std::size_t k = 1; k + 1 < slower.size(); k += 2) slower[k] = 0.5F * (slower[k - 1] + slower[k + 1]);
  draw.sensor_noise_deg *= std::sqrt(2.0);
  const PredictiveCheck found = check(slower, {draw});
  CHECK(found.warning().empty());
  CHECK(p_of(found, "between cycles") > 0.05);
}

TEST_CASE("predictive check: the same figures for any number of threads") {
  const std::vector<State> from = draws();
  const std::vector<float> sway = recorded(from.front(), 2);
  const int threads = omp_get_max_threads();
  std::vector<PredictiveCheck> all;
  for (const int count : {1, 2}) {
    omp_set_num_threads(count);
    all.push_back(check(sway, from));
  }
  omp_set_num_threads(threads);
  REQUIRE(all[0].figures.size() == all[1].figures.size());
  for (std::size_t i = 0; i < all[0].figures.size(); ++i) {
    CHECK(all[0].figures[i].recorded == all[1].figures[i].recorded);
    CHECK(all[0].figures[i].low == all[1].figures[i].low);
    CHECK(all[0].figures[i].p == all[1].figures[i].p);
  }
  CHECK(all[0].sway_rad.high == all[1].sway_rad.high);
  CHECK(checker().check(from, recording::make_trial(sway), 2).figures[0].low != all[0].figures[0].low);
}

TEST_CASE("predictive check: stimuli with one cycle, and draws that fall") {
  sim::Protocol protocol = simulator().protocol();
  auto& sines = std::get<sim::Sines>(protocol.experiment.stimulus);
  sines.cycles = 1;
  sines.components.front().frequency_hz = 0.21;  // not joined: no frequency response
  const sim::Simulator single(protocol);
  std::vector<double> sway(static_cast<std::size_t>(single.samples()));
  REQUIRE(single.run(state().parameters, Random(3, sim::streams::vestibular_noise, 0), sway).valid);
  const recording::Trial trial = recording::make_trial({sway.begin(), sway.end()});
  const PredictiveCheck found = PredictiveChecker(single, 0.1).check(std::vector{state()}, trial, 1);
  CHECK(std::ranges::find(found.figures, "between cycles", &CheckedFigure::name) == found.figures.end());
  CHECK(std::ranges::find(found.figures, "frequency response", &CheckedFigure::name) == found.figures.end());
  CHECK(p_of(found, "level") > PredictiveCheck::odd);

  State falling = state();
  falling.parameters[sim::Kp] = 1258.0;
  falling.parameters[sim::Kd] = 126.0;
  falling.parameters[sim::Delay] = 0.24;
  const PredictiveCheck none = check(recorded(state(), 1), {falling});
  CHECK(none.standing < 100);
  CHECK(none.figures.empty());
  CHECK(contains(none.warning(), "the body stands in 0"));

  // The smallest p is 2 / (standing + 1): a figure that no trial has must be able to warn.
  std::vector<float> large = recorded(state(), 1);
  for (float& value : large) value *= 8.0F;
  for (const int standing : {199, 200}) {
    std::vector<State> draws(PredictiveCheck::trials, falling);
    std::fill_n(draws.begin(), standing, state());
    const PredictiveCheck some = check(large, draws);
    CHECK(some.standing == standing);
    CHECK(some.figures.empty() == (standing < 200));
    if (!some.figures.empty()) CHECK(std::ranges::min(some.figures, {}, &CheckedFigure::p).p < PredictiveCheck::odd);
    CHECK_FALSE(some.warning().empty());
  }
}

TEST_CASE("predictive check: errors") {
  check_error([] { check(std::vector<float>(2999)); }, Code::size_mismatch, "2999 samples");
  check_error([] { checker().check({}, recording::make_trial(std::vector<float>(3000)), 1); }, Code::size_mismatch,
              "0 draws");
}

}  // namespace decid
