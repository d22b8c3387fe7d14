#include "posterior/frf/response.hpp"

#include <mutex>

#include "base/math/random.hpp"
#include "sim/frf.hpp"
#include "sim/simulate.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"
#include "tests/posterior/frf/made_table.hpp"
#include "tests/sim/third_model.hpp"

using namespace decid;
using namespace decid::test;
using sim::Complex;

namespace {

std::vector<Complex> responses_of(const frf::ResponseModel& model, const sim::Parameters& parameters) {
  std::vector<Complex> responses(model.rows());
  model.respond(parameters, responses);
  return responses;
}

/// The mean over simulated trials of their frequency responses behind the first cycle, and its standard error a part.
struct Simulated {
  std::vector<Complex> mean;
  std::vector<double> error;
};

Simulated simulated(const sim::Simulator& simulator, const sim::FrequencyResponse& analysis,
                    const std::vector<float>& tilt, const sim::Parameters& parameters, int trials) {
  Simulated found{std::vector<Complex>(analysis.bands()), std::vector<double>(analysis.bands())};
  std::vector<double> squares(analysis.bands());
  std::mutex mutex;
  simulator.run_all(
      trials,
      [&](int i) {
        return sim::TrialInput{parameters, Random(5, sim::streams::vestibular_noise, static_cast<unsigned>(i))};
      },
      [&](int, const sim::Outcome& outcome, std::span<double> sway) {
        CHECK(outcome.valid);
        const auto points = analysis.measure(std::vector<float>(sway.begin(), sway.end()), tilt);
        const std::lock_guard lock(mutex);
        for (std::size_t i = 0; i < points.size(); ++i) {
          found.mean[i] += points[i].response / static_cast<double>(trials);
          squares[i] += std::norm(points[i].response) / trials;
        }
      });
  for (std::size_t i = 0; i < squares.size(); ++i)
    found.error[i] = std::sqrt(std::max(0.0, squares[i] - std::norm(found.mean[i])) / 2.0 / trials);
  return found;
}

/// Simulated trials of a protocol against the model, up to 2.5 Hz: without noise within `relative` of the response,
/// with noise also within 4.5 standard errors, which the worst of 30 parts exceeds in 1 of 10,000 runs.
void check_against_simulator(const sim::Protocol& protocol, const sim::Parameters& parameters, double relative,
                             int trials, int transient_cycles = 1) {
  const sim::Simulator simulator(protocol);
  const sim::FrequencyResponse analysis(protocol.experiment, transient_cycles);
  std::vector<float> tilt;
  for (int k = 0; k < protocol.samples(); ++k)
    tilt.push_back(static_cast<float>(simulator.stimulus().tilt_at(k * protocol.experiment.steps_per_sample())));
  frf::Table table;
  for (const sim::FrfPoint& point : analysis.measure(tilt, tilt))
    if (point.frequency_hz < 2.5) table.rows.push_back({point.frequency_hz, 1.0, 0.0, point.harmonics});
  const std::vector<Complex> model = responses_of(frf::ResponseModel(protocol, table), parameters);
  const Simulated found = simulated(simulator, analysis, tilt, parameters, trials);
  for (std::size_t i = 0; i < model.size(); ++i) {
    CAPTURE(table.rows[i].frequency_hz);
    CHECK(within(std::abs(found.mean[i] - model[i]), 0.0, relative * std::abs(model[i]) + 4.5 * found.error[i]));
  }
}

sim::Protocol sines() {
  sim::Protocol protocol;
  protocol.name = "sines";
  sim::Sines stimulus;
  stimulus.components = {{0.1, 0.3, 0.0}, {0.3, 0.2, 30.0}, {0.7, 0.1, 60.0}};
  stimulus.cycle_s = 20.0;
  stimulus.cycles = 4;
  protocol.experiment.stimulus = stimulus;
  return protocol;
}

const sim::Parameters usual{800.0, 250.0, 130.0, 120.0, 0.0, 0.002, 0.1};

}  // namespace

TEST_CASE("the passed fraction is the mean over the noise") {
  // Simpson's rule over 10 deviations either way: its error is below 1e-6 with the kinks between its points.
  for (const double theta : {0.0, 0.002, 0.005}) {
    for (const double signal : {0.0, 0.001, 0.0041}) {
      const double stddev = 0.003;
      double sum = 0.0;
      constexpr int points = 20'000;
      for (int i = 0; i <= points; ++i) {
        const double u = -10.0 + 20.0 * i / points, x = signal + stddev * u;
        const double passed = x > theta ? x - theta : x < -theta ? x + theta : 0.0;
        const double weight = i == 0 || i == points ? 1.0 : i % 2 ? 4.0 : 2.0;
        sum += weight * passed * std::exp(-0.5 * u * u) / std::sqrt(2.0 * sim::pi) * 20.0 / points / 3.0;
      }
      CHECK(within(frf::mean_passed(signal, stddev, theta), sum, 1e-9));
    }
  }
  CHECK(near(frf::mean_passed(0.004, 0.0, 0.001), 0.003, 1e-9));
  CHECK(within(frf::mean_passed(0.004, 0.0, 0.005), 0.0, 1e-15));
  CHECK(near(frf::mean_passed(-0.004, 0.0, 0.001), -0.003, 1e-9));
}

// The remaining error without noise comes from sampling: kinks between samples, (pi f / rate)^2 / 3, 0.0016 at 2.2 Hz.
TEST_CASE("the response is the simulator's, without noise") {
  for (const double theta : {0.0, 0.002, 0.005}) {
    sim::Parameters parameters = usual;
    parameters[sim::Theta] = theta;
    check_against_simulator(sim::default_protocol(), parameters, 0.0025, 1);
    check_against_simulator(sim::short_protocol(), parameters, 0.004, 1);
    check_against_simulator(sines(), parameters, 0.004, 1);
  }
}

TEST_CASE("the response is the mean of the simulator's, with noise") {
  for (const double nv : {0.1, 0.3}) {
    sim::Parameters parameters = usual;
    parameters[sim::Nv] = nv;
    parameters[sim::Theta] = 0.003;
    check_against_simulator(sim::default_protocol(), parameters, 0.0025, 200);
    check_against_simulator(sines(), parameters, 0.004, 200);
  }
}

// Slow feedback settles with 15 to 20 s, in cycles of 60.5 s.
TEST_CASE("the response is the simulator's for every model") {
  const std::vector<std::pair<const sim::BodyModel*, sim::Parameters>> models{
      {&sim::dec2015(), {840.0, 250.0, 126.0, 38.0, 0.0, 0.004, 0.15, 0.85, 0.75, 0.55, 0.13}},
      {&sim::independent_channels(), {1200.0, 350.0, 0.6, 0.02, 0.0, 0.16}},
      {&third_model(), {0.1, 1000.0, 280.0, 0.9, 0.1, 0.015, 0.002, 0.0}}};
  for (const auto& [model, parameters] : models) {
    const std::string name(model->name);
    CAPTURE(name);
    sim::Protocol protocol = with_model(sim::default_protocol(), *model);
    protocol.sequence().cycles = 6;
    check_against_simulator(protocol, parameters, 0.004, 1, 4);
    sim::Parameters noisy = parameters;
    for (std::size_t p = 0; p < model->parameters.size(); ++p)
      if (model->parameters[p].name == "Nv") noisy[p] = 0.2;
    check_against_simulator(protocol, noisy, 0.004, 60, 4);
  }
}

TEST_CASE("without a dead band noise changes nothing") {
  const frf::ResponseModel model(with_model(sim::short_protocol(), sim::independent_channels()),
                                 empty_table(short_frequencies_hz, 0.1));
  const auto quiet = responses_of(model, {1200.0, 350.0, 0.6, 0.02, 0.0, 0.16});
  const auto noisy = responses_of(model, {1200.0, 350.0, 0.6, 0.02, 0.9, 0.16});
  for (std::size_t i = 0; i < quiet.size(); ++i) CHECK(within(std::abs(quiet[i] - noisy[i]), 0.0, 1e-12));
}

TEST_CASE("slopes of the passing gain are those of finite differences") {
  const frf::ResponseModel model(sines(), empty_table({0.1, 0.3, 0.7}, 0.1));
  const auto slopes = model.passing_slopes(0.3, 0.002);
  const double by_nv = (model.passing_gain(0.301, 0.002) - model.passing_gain(0.299, 0.002)) / 0.002;
  const double by_theta = (model.passing_gain(0.3, 0.00201) - model.passing_gain(0.3, 0.00199)) / 0.00002;
  CHECK(near(slopes.by_nv, by_nv, 1e-4));
  CHECK(near(slopes.by_theta, by_theta, 1e-4));
}

TEST_CASE("at threshold 0 it is the closed loop") {
  sim::Parameters parameters = usual;
  parameters[sim::Theta] = 0.0;
  const sim::Protocol protocol = sim::short_protocol();
  const auto model = responses_of({protocol, empty_table(short_frequencies_hz, 0.1)}, parameters);
  for (std::size_t i = 0; i < model.size(); ++i) {
    // The steps of 1 ms are 2 pi f / 1000 of a radian.
    const Complex expected = sim::closed_loop(protocol.experiment, parameters, short_frequencies_hz[i]);
    CHECK(within(std::abs(model[i] - expected), 0.0, 0.01 * std::abs(expected)));
  }
}

TEST_CASE("rows of several harmonics are their mean") {
  const sim::Protocol protocol = sim::short_protocol();
  const auto one = responses_of({protocol, empty_table({0.25, 0.3, 0.35}, 0.1)}, usual);
  const auto two = responses_of({protocol, empty_table({0.29, 0.55, 0.9}, 0.1, 2)}, usual);
  // 0.29 Hz is nearest to 0.25 and 0.35 Hz, of which the lower has more power.
  const double fraction = std::real((two[0] - one[2]) / (one[0] - one[2]));
  CHECK(fraction > 0.5);
  CHECK(fraction < 0.8);
  CHECK(within(std::abs(two[0] - (fraction * one[0] + (1.0 - fraction) * one[2])), 0.0, 1e-9));
}

TEST_CASE("a loop is stable up to the delay at which it oscillates") {
  const frf::ResponseModel model(sim::default_protocol(), empty_table({0.05, 0.4, 1.1}, 0.1));
  sim::Parameters parameters = usual;
  parameters[sim::Theta] = 0.0;
  double stable_s = 0.0, unstable_s = 1.0;
  for (int i = 0; i < 40; ++i) {
    parameters[sim::Delay] = 0.5 * (stable_s + unstable_s);
    (model.is_stable(parameters) ? stable_s : unstable_s) = parameters[sim::Delay];
  }
  // There a frequency has no denominator.
  double least = 1e9;
  parameters[sim::Delay] = stable_s;
  for (double hz = 0.2; hz < 3.0; hz += 0.0005)
    least = std::min(least, 1.0 / std::abs(sim::closed_loop(sim::Experiment{}, parameters, hz)));
  CHECK(least < 2e-3);
  CHECK(stable_s > 0.1);
  parameters[sim::Delay] = 0.0;
  CHECK(model.is_stable(parameters));
  parameters[sim::Kp] = 300.0;  // 2 Kp + Kp_pass below m g h: it falls
  CHECK_FALSE(model.is_stable(parameters));
}

TEST_CASE("no response is an error") {
  const auto with = [](const sim::Protocol& protocol, const std::vector<double>& hz, int harmonics) {
    return [=] { frf::ResponseModel(protocol, empty_table(hz, 0.1, harmonics)); };
  };
  check_error(with(sim::default_protocol(), {0.05, 0.4, 30.0}, 0), Code::protocol_mismatch, "30 Hz");
  check_error(with(sines(), {0.1, 0.3, 0.5}, 0), Code::protocol_mismatch, "0.5 Hz");
  check_error(with(sines(), {0.1, 0.3, 0.7}, 4), Code::protocol_mismatch, "4 harmonics");
  sim::Protocol still = sines();
  std::get<sim::Sines>(still.experiment.stimulus).components = {{0.1, 0.0, 0.0}};
  CHECK_THROWS_AS(with(still, {0.1, 0.3, 0.7}, 0)(), Error);
  sim::Protocol table_only = sim::default_protocol();
  static const sim::BodyModel no_family{.name = "no family", .parameters = sim::single_pendulum().parameters};
  table_only.experiment.body_model = &no_family;
  CHECK_THROWS_AS(with(table_only, {0.05, 0.4, 1.1}, 0)(), Error);
  const frf::ResponseModel model(sim::default_protocol(), empty_table({0.05, 0.4, 1.1}, 0.1));
  std::vector<Complex> few(2);
  check_error([&] { model.respond(usual, few); }, Code::size_mismatch, "2 responses");
}
