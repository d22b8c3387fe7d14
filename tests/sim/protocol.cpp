// Tests of sim/protocol.hpp: the ternary sequences, the stimulus made of them, and every bound of the settings.
#include "sim/protocol.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "base/error.hpp"
#include "sim/noise.hpp"
#include "tests/near.hpp"

using namespace decid::sim;
using decid::test::near;

namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

const auto not_a_number = std::numeric_limits<double>::quiet_NaN();
const auto infinity = std::numeric_limits<double>::infinity();

auto occurrences(const std::vector<int>& values, int value) {
  return std::count(values.begin(), values.end(), value);
}

// Highest minus lowest of the accumulated sum.
int divisor(const std::vector<int>& values) {
  int sum = 0, low = 0, high = 0;
  for (const int value : values) {
    sum += value;
    low = std::min(low, sum);
    high = std::max(high, sum);
  }
  return high - low;
}

double peak_to_peak(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return *high - *low;
}

}  // namespace

TEST_CASE("ternary_sequence: the default sequence") {
  const std::vector<int> values = ternary_sequence(Sequence{});
  REQUIRE(values.size() == 242);
  CHECK(occurrences(values, 0) == 80);
  CHECK(occurrences(values, 1) == 81);
  CHECK(occurrences(values, -1) == 81);
  bool negated = true;
  for (std::size_t i = 0; i < 121; ++i) negated = negated && values[i + 121] == -values[i];
  CHECK(negated);
  CHECK(divisor(values) == 17);
  // By hand, v = (r3 - r4 - r5) mod 3: register 20202 gives 0, 02020 gives 1, 10202 0, 01020 1, 10102 2, 21010 2.
  const std::vector<int> first(values.begin(), values.begin() + 6);
  CHECK(first == std::vector<int>{0, 1, 0, 1, -1, -1});
}

TEST_CASE("ternary_sequence: the short sequence") {
  const std::vector<int> values = ternary_sequence(short_protocol().sequence());
  CHECK(values.size() == 80);
  CHECK(occurrences(values, 0) == 26);
  CHECK(occurrences(values, 1) == 27);
  CHECK(occurrences(values, -1) == 27);
}

TEST_CASE("ternary_sequence: errors") {
  Sequence sequence;
  sequence.feedback = {0, 0, 1, -1, 0};  // forgets its last stage
  CHECK_THROWS_AS(ternary_sequence(sequence), decid::Error);
  sequence.feedback = {0, 0, 1, -1};
  CHECK_THROWS_AS(ternary_sequence(sequence), decid::Error);
}

TEST_CASE("make_stimulus: default protocol") {
  const Protocol protocol = default_protocol();
  protocol.validate();
  CHECK(protocol.experiment.steps() == 121'000);
  CHECK(protocol.samples() == 12'100);
  CHECK(protocol.experiment.steps_per_sample() == 10);
  CHECK(protocol.duration_s() == 121.0);
  CHECK(protocol.experiment.cycle_s() == 60.5);

  const Stimulus stimulus = make_stimulus(protocol.experiment);
  const std::vector<double>& tilt = stimulus.tilt_rad;
  REQUIRE(stimulus.interval_steps == 10);
  REQUIRE(tilt.size() == 12'101);
  REQUIRE(stimulus.rate_rad_s.size() == 12'100);
  CHECK(tilt[0] == 0.0);
  CHECK(std::abs(peak_to_peak(tilt) / rad_per_deg - 1.0) < 2.0 * eps);

  const double rate = rad_per_deg / 4.25;
  double rate_error = 0.0, tilt_error = 0.0;
  bool cycles_equal = true, ternary = true;
  for (std::size_t k = 0; k < 12'100; ++k) {
    const double v = stimulus.rate_rad_s[k] / rate;
    ternary = ternary && (std::abs(v) < 4.0 * eps || std::abs(std::abs(v) - 1.0) < 4.0 * eps);
    rate_error = std::max(rate_error, std::abs((tilt[k + 1] - tilt[k]) * 100.0 - stimulus.rate_rad_s[k]));
    if (k >= 6'050) {
      cycles_equal =
          cycles_equal && tilt[k] == tilt[k - 6'050] && stimulus.rate_rad_s[k] == stimulus.rate_rad_s[k - 6'050];
    } else {
      // The second half is the first negated: the tilt goes back the way it came.
      tilt_error = std::max(tilt_error, std::abs((tilt[k + 3'025] - tilt[3'025]) + tilt[k] - tilt[0]));
    }
  }
  CHECK(ternary);
  CHECK(cycles_equal);
  CHECK(tilt.back() == 0.0);
  // Tilts are below rad_per_deg and rounded to eps / 2 of it; a difference of two, a hundredfold.
  CHECK(rate_error < 100.0 * eps * rad_per_deg);
  CHECK(tilt_error < 4.0 * eps * rad_per_deg);
}

TEST_CASE("make_stimulus: the trial starts at its offset, 120 ms before a new state") {
  const Protocol protocol = default_protocol();
  const std::vector<int> values = ternary_sequence(protocol.sequence());
  const Stimulus stimulus = make_stimulus(protocol.experiment);
  const double rate = rad_per_deg / 4.25;
  // 25.63 s = 102 states and 130 ms.
  struct Case {
    int step;
    std::size_t state;
  };
  for (const Case& c : {Case{0, 102}, Case{119, 102}, Case{120, 103}, Case{369, 103}, Case{370, 104}}) {
    const double expected = values[c.state] * rate;
    CAPTURE(c.step);
    CHECK(near(stimulus.rate_at(c.step), expected, 4.0 * eps));  // four roundings each way
  }
  // Where it starts is in the middle of the range, to within a state.
  const auto [low, high] = std::minmax_element(stimulus.tilt_rad.begin(), stimulus.tilt_rad.end());
  CHECK(std::abs(*low + *high) < rad_per_deg / 8.0);
}

TEST_CASE("make_stimulus: short protocol") {
  const Protocol protocol = short_protocol();
  protocol.validate();
  CHECK(protocol.experiment.steps() == 63'700);
  CHECK(protocol.samples() == 6'370);
  CHECK(protocol.experiment.cycle_s() == 20.0);
  const Stimulus stimulus = make_stimulus(protocol.experiment);
  REQUIRE(stimulus.interval_steps == 10);
  CHECK(near(peak_to_peak(stimulus.tilt_rad), rad_per_deg, 2.0 * eps));
  const auto& rate = stimulus.rate_rad_s;
  const auto is_zero = [](double x) { return x == 0.0; };
  CHECK(std::all_of(rate.begin(), rate.begin() + 197, is_zero));
  CHECK(std::all_of(rate.begin() + 6'197, rate.end(), is_zero));
  CHECK(std::all_of(stimulus.tilt_rad.begin(), stimulus.tilt_rad.begin() + 197, is_zero));
  CHECK(std::all_of(stimulus.tilt_rad.begin() + 6'197, stimulus.tilt_rad.end(), is_zero));
  CHECK(std::equal(rate.begin() + 197, rate.begin() + 2'197, rate.begin() + 4'197));
  const std::vector<int> values = ternary_sequence(protocol.sequence());
  for (const std::size_t state : {0u, 1u, 2u, 3u, 79u}) {
    const double expected = values[state] * rad_per_deg / (0.25 * divisor(values));
    CHECK(near(rate[197 + 25 * state], expected, 4.0 * eps));
  }
}

TEST_CASE("make_stimulus: amplitude scales the tilt; rest after the last cycle keeps it") {
  Protocol protocol;
  protocol.sequence().amplitude_deg = 4.0;
  protocol.sequence().cycles = 1;
  protocol.sequence().lead_out_s = 0.5;
  const Stimulus stimulus = make_stimulus(protocol.experiment);
  CHECK(stimulus.tilt_rad.size() == 6'101);
  CHECK(near(peak_to_peak(stimulus.tilt_rad), 4.0 * rad_per_deg, 2.0 * eps));
  CHECK(stimulus.tilt_rad.back() == 0.0);
}

TEST_CASE("Stimulus: between the points of its grid, and a grid as fine as the sequence asks for") {
  Protocol protocol;
  protocol.sequence().offset_s = 25.634;
  protocol.validate();
  const Stimulus fine = make_stimulus(protocol.experiment);
  CHECK(fine.interval_steps == 2);
  protocol.sequence().offset_s = 25.63;
  const Stimulus stimulus = make_stimulus(protocol.experiment);
  // Both play one sequence, 4 ms apart.
  const double first = fine.tilt_at(0), shift = stimulus.tilt_at(4) - first;
  double difference = 0.0;
  for (int step = 0; step < 120'000; step += 7) {
    difference = std::max(difference, std::abs(stimulus.tilt_at(step + 4) - shift - fine.tilt_at(step)));
    CHECK(stimulus.rate_at(step + 4) == fine.rate_at(step));
  }
  CHECK(difference < 4.0 * std::numeric_limits<double>::epsilon() * rad_per_deg);
}

TEST_CASE("Protocol::validate: every bound") {
  struct Case {
    const char* setting;  // part of what the error says
    std::function<void(Protocol&)> spoil;
  };
  const std::vector<Case> cases{
      {"sequence", [](Protocol& p) { p.sequence().feedback = {1}, p.sequence().start = {1}; }},
      {"sequence", [](Protocol& p) { p.sequence().feedback.assign(13, 1), p.sequence().start.assign(13, 1); }},
      {"sequence",
       [](Protocol& p) {
         p.sequence().start = {1, 0, 0};
       }},
      {"sequence", [](Protocol& p) { p.sequence().feedback.back() = 0; }},
      {"sequence feedback", [](Protocol& p) { p.sequence().feedback[0] = 3; }},
      {"sequence feedback", [](Protocol& p) { p.sequence().feedback[0] = -3; }},
      {"sequence feedback",
       [](Protocol& p) {
         p.sequence().feedback = {0, 1}, p.sequence().start = {1, 1};
       }},  // 1 1 1 ...: a ramp
      {"sequence start", [](Protocol& p) { p.sequence().start[1] = 3; }},
      {"sequence start", [](Protocol& p) { p.sequence().start[1] = -1; }},
      {"sequence start", [](Protocol& p) { p.sequence().start.assign(5, 0); }},
      {"sequence state_s", [](Protocol& p) { p.sequence().state_s = 0.0; }},
      {"sequence state_s", [](Protocol& p) { p.sequence().state_s = 0.2505; }},
      {"sequence state_s", [](Protocol& p) { p.sequence().state_s = not_a_number; }},
      {"sequence state_s", [](Protocol& p) { p.sequence().state_s = infinity; }},
      {"sequence amplitude_deg", [](Protocol& p) { p.sequence().amplitude_deg = 0.0; }},
      {"sequence amplitude_deg", [](Protocol& p) { p.sequence().amplitude_deg = -1.0; }},
      {"sequence amplitude_deg", [](Protocol& p) { p.sequence().amplitude_deg = 46.0; }},
      {"sequence amplitude_deg", [](Protocol& p) { p.sequence().amplitude_deg = not_a_number; }},
      {"sequence offset_s", [](Protocol& p) { p.sequence().offset_s = -0.001; }},
      {"sequence offset_s", [](Protocol& p) { p.sequence().offset_s = 60.5; }},
      {"sequence offset_s", [](Protocol& p) { p.sequence().offset_s = 1.0005; }},
      {"sequence offset_s", [](Protocol& p) { p.sequence().offset_s = not_a_number; }},
      {"sequence cycles", [](Protocol& p) { p.sequence().cycles = 0; }},
      {"sequence cycles", [](Protocol& p) { p.sequence().cycles = std::numeric_limits<int>::max(); }},
      {"sequence lead_in_s", [](Protocol& p) { p.sequence().lead_in_s = -1.0; }},
      {"sequence lead_in_s", [](Protocol& p) { p.sequence().lead_in_s = 0.0005; }},
      {"sequence lead_in_s", [](Protocol& p) { p.sequence().lead_in_s = not_a_number; }},
      {"sequence lead_out_s", [](Protocol& p) { p.sequence().lead_out_s = infinity; }},
      {"sequence lead_out_s", [](Protocol& p) { p.sequence().lead_out_s = 1.0001; }},
      {"at most 3600 s", [](Protocol& p) { p.sequence().cycles = 60; }},
      {"at most 3600 s", [](Protocol& p) { p.sequence().state_s = 3600.0; }},
      {"at most 3600 s", [](Protocol& p) { p.sequence().lead_in_s = 3600.0; }},
      {"number of samples", [](Protocol& p) { p.sequence().lead_out_s = 0.005; }},
      {"sample_rate_hz", [](Protocol& p) { p.experiment.sample_rate_hz = 0.0; }},
      {"sample_rate_hz", [](Protocol& p) { p.experiment.sample_rate_hz = 62.5; }},
      {"sample_rate_hz", [](Protocol& p) { p.experiment.sample_rate_hz = 30.0; }},
      {"sample_rate_hz", [](Protocol& p) { p.experiment.sample_rate_hz = 2000.0; }},
      {"sample_rate_hz", [](Protocol& p) { p.experiment.sample_rate_hz = not_a_number; }},
      {"mass_kg", [](Protocol& p) { p.experiment.body.mass_kg = 0.0; }},
      {"mass_kg", [](Protocol& p) { p.experiment.body.mass_kg = 1000.0; }},
      {"com_height_m", [](Protocol& p) { p.experiment.body.com_height_m = -1.0; }},
      {"com_height_m", [](Protocol& p) { p.experiment.body.com_height_m = 6.0; }},
      {"inertia_kgm2", [](Protocol& p) { p.experiment.body.inertia_kgm2 = not_a_number; }},
      {"inertia_kgm2", [](Protocol& p) { p.experiment.body.inertia_kgm2 = 1e5; }},
      {"scale_deg", [](Protocol& p) { p.noise.vestibular.scale_deg = -0.1; }},
      {"scale_deg", [](Protocol& p) { p.noise.vestibular.scale_deg = infinity; }},
      {"high_hz", [](Protocol& p) { p.noise.vestibular.high_hz = 10.001; }},
      {"high_hz", [](Protocol& p) { p.noise.vestibular.high_hz = not_a_number; }},
      {"low_hz", [](Protocol& p) { p.noise.vestibular.low_hz = 0.0; }},
      {"period_s", [](Protocol& p) { p.noise.vestibular.period_s = 120.99; }},
      {"period_s", [](Protocol& p) { p.noise.vestibular.period_s = 12'100.01; }},
      {"period_s", [](Protocol& p) { p.noise.vestibular.period_s = -121.0; }},
      {"period_s", [](Protocol& p) { p.noise.vestibular.period_s = 121.005; }},
      {"period_s", [](Protocol& p) { p.noise.vestibular.period_s = 200.11; }},  // 20,011 is a prime
      {"period_s", [](Protocol& p) { p.noise.vestibular.period_s = std::numeric_limits<double>::quiet_NaN(); }},
      {"low_hz", [](Protocol& p) { p.noise.vestibular.low_hz = 1.1; }},
      {"exponent", [](Protocol& p) { p.noise.vestibular.exponent = -0.1; }},
      {"exponent", [](Protocol& p) { p.noise.vestibular.exponent = 4.1; }},
      {"sensor_noise_deg",
       [](Protocol& p) {
         p.noise.sensor = {-0.1, 0.1};
       }},
      {"sensor_noise_deg",
       [](Protocol& p) {
         p.noise.sensor = {0.2, 0.1};
       }},
      {"sensor_noise_deg",
       [](Protocol& p) {
         p.noise.sensor = {0.0, 0.1};
       }},
      {"sensor_noise_deg",
       [](Protocol& p) {
         p.noise.sensor = {0.1, infinity};
       }},
      {"sensor_noise_deg",
       [](Protocol& p) {
         p.noise.sensor = {not_a_number, 0.1};
       }},
  };
  for (std::size_t i = 0; i < cases.size(); ++i) {
    Protocol protocol;
    cases[i].spoil(protocol);
    CAPTURE(i);
    std::string message = "no error";
    try {
      protocol.validate();
    } catch (const decid::Error& error) {
      message = error.what();
    }
    CAPTURE(message);
    CHECK(message.find(cases[i].setting) != std::string::npos);
  }
}

TEST_CASE("Protocol: standing") {
  const auto refused = [](double standing_s, double rate_hz = 100.0) {
    Protocol protocol;
    protocol.experiment.sample_rate_hz = rate_hz;
    protocol.standing_s = standing_s;
    try {
      protocol.validate();
    } catch (const decid::Error& error) {
      return std::string(error.what()).find("standing_s") != std::string::npos;
    }
    return false;
  };
  for (const double right : {0.0, 0.01, 10.0, 59.99, 60.0}) CHECK_FALSE(refused(right));
  for (const double wrong : {-1.0, -0.01, 60.01, 0.005, 0.0101, not_a_number, infinity}) CHECK(refused(wrong));
  CHECK(refused(0.05, 10.0));
  CHECK_FALSE(refused(0.05, 20.0));

  Protocol protocol;
  protocol.standing_s = 10.0;
  CHECK(protocol.ideal().standing_s == 10.0);
  CHECK(protocol.experiment == Protocol{}.experiment);
  CHECK(protocol.duration_s() == 121.0);
  CHECK(protocol.with_standing().duration_s() == 131.0);
  CHECK(protocol.with_standing().experiment.lead_in_s() == 10.0);
  CHECK(protocol.with_standing().standing_s == 0.0);
  // A period that is long enough stays; another is twice what is simulated.
  CHECK(protocol.with_standing().noise_period_s() == 242.0);
  protocol.noise.vestibular.period_s = 131.0;
  CHECK(protocol.with_standing().noise_period_s() == 131.0);
  protocol.noise.vestibular.period_s = 130.99;
  CHECK(protocol.with_standing().noise_period_s() == 262.0);
  protocol.noise.vestibular.period_s = 121.0;
  CHECK(protocol.with_standing().noise_period_s() == 262.0);

  // Twice what is simulated must be a length that can be transformed: 12,109 is a prime.
  protocol.standing_s = 0.09;
  std::string message;
  try {
    protocol.validate();
  } catch (const decid::Error& error) {
    message = error.what();
  }
  CHECK(message.find("standing_s") != std::string::npos);
  CHECK(message.find("12109") != std::string::npos);
}

TEST_CASE("Protocol::validate: the noise's band holds a harmonic, unless it is silent") {
  Protocol protocol;
  protocol.noise.vestibular.low_hz = 0.501;
  protocol.noise.vestibular.high_hz = 0.502;
  // 122 / 242 Hz is above, 121 / 242 Hz below.
  CHECK_THROWS_WITH_AS(protocol.validate(), doctest::Contains("multiple of 0.004132231405 Hz, 1 / 242 s"),
                       decid::Error);
  CHECK_THROWS_WITH_AS(protocol.validate(), doctest::Contains("protocol default, vestibular_noise"), decid::Error);
  protocol.noise.vestibular.high_hz = 61.0 / 121.0;
  CHECK_NOTHROW(protocol.validate());
  CHECK(noise_band(protocol).first == 122);
  CHECK(noise_band(protocol).last == 122);
  protocol.noise.vestibular.high_hz = 0.502;
  protocol.noise.vestibular.scale_deg = 0.0;
  CHECK_NOTHROW(protocol.validate());
  CHECK_NOTHROW(VestibularNoiseMaker{protocol});
  protocol = {};
  CHECK(noise_band(protocol).first == 2);
  CHECK(noise_band(protocol).last == 242);
  protocol.noise.vestibular.period_s = 121.0;
  CHECK(noise_band(protocol).first == 1);
  CHECK(noise_band(protocol).last == 121);
}

TEST_CASE("Protocol: the noise's period is twice the trial's length, whatever that is, unless it is given") {
  Protocol protocol;
  CHECK(protocol.noise_period_samples() == 24'200);
  CHECK(protocol.noise_period_s() == 242.0);
  protocol.sequence().cycles = 3;
  CHECK(protocol.noise_period_s() == 363.0);
  CHECK(short_protocol().noise_period_s() == 127.4);
  protocol.noise.vestibular.period_s = 200.03;
  CHECK(protocol.noise_period_samples() == 20'003);
  CHECK(protocol.noise_period_s() == 200.03);
}

TEST_CASE("Protocol::validate: trials of all lengths that can be transformed, and of no others") {
  Protocol protocol;
  Sines sines{.components = {{.frequency_hz = 0.1, .amplitude_deg = 0.5}}, .cycle_s = 200.11};
  protocol.experiment.stimulus = sines;  // 20,011 is a prime, 20,012 = 4 * 5,003
  CHECK_THROWS_WITH_AS(protocol.validate(), doctest::Contains("the trial: has 20011 samples"), decid::Error);
  CHECK_THROWS_WITH_AS(protocol.validate(), doctest::Contains("lengthen lead_out_s by 0.01 s"), decid::Error);
  CHECK_THROWS_AS(VestibularNoiseMaker{protocol}, decid::Error);
  sines.lead_out_s = 0.01;
  protocol.experiment.stimulus = sines;
  CHECK_NOTHROW(protocol.validate());
  CHECK_NOTHROW(VestibularNoiseMaker{protocol});
  Protocol sequence;
  sequence.sequence().lead_out_s = 79.11;  // 20,011 samples
  CHECK_THROWS_WITH_AS(sequence.validate(), doctest::Contains("20011"), decid::Error);
  sines = {.components = sines.components, .cycle_s = 99.73};  // 9,973 is the largest prime that can be
  protocol.experiment.stimulus = sines;
  CHECK_NOTHROW(protocol.validate());
}

TEST_CASE("Protocol::refuse_implausible: names, bodies and joints") {
  CHECK_NOTHROW(Protocol{}.refuse_implausible());
  CHECK_NOTHROW(short_protocol().refuse_implausible());
  const auto message = [](const auto& change) -> std::string {
    Protocol protocol;
    change(protocol);
    protocol.validate();
    try {
      protocol.refuse_implausible();
    } catch (const decid::Error& error) {
      return error.what();
    }
    return "";
  };
  for (const char* name : {"a\nb", "\x1b[2J", "tab\t", "del\x7f", "csi\xC2\x9B"}) {
    const std::string said = message([&](Protocol& p) { p.name = name; });
    CHECK(said.find("protocol name: has a control character at byte") == 0);
    CHECK(said.find(name) == std::string::npos);
  }
  for (const char* name : {"", "plain", "\xC3\xA4 \xC2\xB0 \xE2\x82\xAC", "no-break\xC2\xA0space"}) {
    CHECK(message([&](Protocol& p) { p.name = name; }).empty());
  }

  // 86.283 kg at 0.99119 m.
  const double least = 86.283 * 0.99119 * 0.99119;
  const auto inertia = [&](double value) {
    return message([=](Protocol& p) { p.experiment.body.inertia_kgm2 = value; });
  };
  CHECK(inertia(least).empty());
  CHECK(inertia(least * (1.0 - 0.9e-6)).empty());
  CHECK(inertia(least * (1.0 - 1.1e-6)).find("body inertia_kgm2: is 84.7") != std::string::npos);
  CHECK(inertia(80.0).find("is 80, below mass_kg * com_height_m^2 = 84.76") != std::string::npos);

  const auto joint = [&](std::vector<double> tilt, int cycles) {
    return message([&](Protocol& p) {
      p.experiment.stimulus = MeasuredTilt{.tilt_deg = tilt, .cycles = cycles};
      p.noise.vestibular.scale_deg = 0.0;
    });
  };
  std::vector<double> ramp;
  for (int k = 0; k <= 1000; ++k) ramp.push_back(0.04 * k);
  CHECK(joint(ramp, 1).empty());
  CHECK(joint(ramp, 3).find("measured tilt_deg: jumps by 40 degrees") != std::string::npos);
  CHECK(joint(ramp, 3).find("cycles 1") != std::string::npos);
  CHECK(joint({0.0, 0.1, 0.2, 0.3, 0.4, 0.5}, 2).empty());  // 5 steps
  CHECK(joint({0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6}, 2).find("by 0.1 at most") != std::string::npos);
  CHECK(joint({0.0, 0.001, 0.002, 0.003, 0.004, 0.005, 0.006, 0.007, 0.008, 0.009}, 2).empty());  // below 0.01 degrees
  CHECK(joint({1.0, 1.0, 1.0}, 2).empty());
}

TEST_CASE("Protocol::validate: the ends of the bounds are inside") {
  Protocol protocol;
  protocol.sequence().offset_s = 60.499;
  protocol.sequence().amplitude_deg = 45.0;
  protocol.noise.vestibular.high_hz = 10.0;
  protocol.noise.vestibular.exponent = 0.0;
  protocol.noise.sensor = {0.1, 0.1};
  CHECK_NOTHROW(protocol.validate());
  protocol.noise.vestibular.high_hz = protocol.noise.vestibular.low_hz = 1.0;
  protocol.experiment.sample_rate_hz = 1000.0;
  CHECK_NOTHROW(protocol.validate());
  protocol.noise.vestibular = {.scale_deg = 0.0, .low_hz = 0.05, .high_hz = 0.1, .exponent = 4.0};
  protocol.experiment.sample_rate_hz = 1.0;
  CHECK_NOTHROW(protocol.validate());
}

TEST_CASE("Experiment: equal ones; noise and name may differ, nothing else") {
  const Protocol a;
  Protocol b;
  b.name = "other";
  b.noise.vestibular.scale_deg = 1.0;
  b.noise.sensor = {0.1, 0.2};
  CHECK(a.experiment == b.experiment);
  const auto differs = [&](auto change) {
    Protocol c;
    change(c);
    return a.experiment != c.experiment;
  };
  CHECK(differs([](Protocol& p) { p.sequence().feedback[0] = 1; }));
  CHECK(differs([](Protocol& p) { p.sequence().start[1] = 1; }));
  CHECK(differs([](Protocol& p) { p.sequence().state_s = 0.2; }));
  CHECK(differs([](Protocol& p) { p.sequence().amplitude_deg = 2.0; }));
  CHECK(differs([](Protocol& p) { p.sequence().offset_s = 0.0; }));
  CHECK(differs([](Protocol& p) { p.sequence().cycles = 1; }));
  CHECK(differs([](Protocol& p) { p.sequence().lead_in_s = 1.0; }));
  CHECK(differs([](Protocol& p) { p.sequence().lead_out_s = 1.0; }));
  CHECK(differs([](Protocol& p) { p.experiment.sample_rate_hz = 50.0; }));
  CHECK(differs([](Protocol& p) { p.experiment.body.mass_kg = 80.0; }));
  CHECK(differs([](Protocol& p) { p.experiment.body.com_height_m = 1.0; }));
  CHECK(differs([](Protocol& p) { p.experiment.body.inertia_kgm2 = 100.0; }));
}

TEST_CASE("Protocol: ranges of the default body are the table's; a lighter body's gains are as wide over its m g h") {
  decid::sim::Protocol protocol = decid::sim::default_protocol();
  for (std::size_t p = 0; p < protocol.parameters().size(); ++p) {
    CHECK(protocol.ranges()[p].low == protocol.parameters()[p].low);
    CHECK(protocol.ranges()[p].high == protocol.parameters()[p].high);
  }
  const double mgh = protocol.experiment.body.mgh();
  protocol.experiment.body.mass_kg *= 0.5;
  const decid::sim::ParameterTable lighter = protocol.ranges();
  for (std::size_t p = 0; p < lighter.size(); ++p) {
    const decid::sim::ParameterInfo& info = protocol.parameters()[p];
    CHECK(near(lighter[p].low, info.low * (info.per_mgh ? 0.5 : 1.0), 1e-12 * std::abs(info.high)));
    CHECK(near(lighter[p].high, info.high * (info.per_mgh ? 0.5 : 1.0), 1e-12 * info.high));
  }
  CHECK(near(lighter[decid::sim::Kp].high / protocol.experiment.body.mgh(),
             protocol.parameters()[decid::sim::Kp].high / mgh, 1e-12));
}
