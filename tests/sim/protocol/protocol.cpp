// Tests of sim/protocol/protocol.hpp: every bound of the settings.
#include "sim/protocol/protocol.hpp"

#include <cmath>
#include <functional>
#include <limits>

#include "base/error.hpp"
#include "sim/noise.hpp"
#include "tests/helpers.hpp"

using namespace decid::sim;
using namespace decid::test;

namespace {

const auto not_a_number = std::numeric_limits<double>::quiet_NaN();
const auto infinity = std::numeric_limits<double>::infinity();

}  // namespace

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
    const std::string message = message_of([&] { protocol.validate(); });
    CAPTURE(message);
    CHECK(contains(message, cases[i].setting));
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
  check_error([&] { protocol.validate(); }, decid::Code::setting_out_of_range, "standing_s");
}

TEST_CASE("Protocol::validate: the noise's band holds a harmonic, unless it is silent") {
  Protocol protocol;
  protocol.noise.vestibular.low_hz = 0.501;
  protocol.noise.vestibular.high_hz = 0.502;
  // 122 / 242 Hz is above, 121 / 242 Hz below.
  check_error([&] { protocol.validate(); }, decid::Code::setting_out_of_range, "0.004132231405 Hz");
  check_error([&] { protocol.validate(); }, decid::Code::setting_out_of_range, "vestibular_noise");
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
  check_error([&] { protocol.validate(); }, decid::Code::setting_out_of_range, "20011 samples");
  check_error([&] { protocol.validate(); }, decid::Code::setting_out_of_range, "lead_out_s");
  CHECK_THROWS_AS(VestibularNoiseMaker{protocol}, decid::Error);
  sines.lead_out_s = 0.01;
  protocol.experiment.stimulus = sines;
  CHECK_NOTHROW(protocol.validate());
  CHECK_NOTHROW(VestibularNoiseMaker{protocol});
  Protocol sequence;
  sequence.sequence().lead_out_s = 79.11;  // 20,011 samples
  check_error([&] { sequence.validate(); }, decid::Code::setting_out_of_range, "20011");
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
    CHECK_FALSE(contains(said, name));
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
  CHECK(contains(inertia(least * (1.0 - 1.1e-6)), "body inertia_kgm2: is 84.7"));
  CHECK(contains(inertia(80.0), "is 80, below mass_kg * com_height_m^2 = 84.76"));

  const auto joint = [&](std::vector<double> tilt, int cycles) {
    return message([&](Protocol& p) {
      p.experiment.stimulus = MeasuredTilt{.tilt_deg = tilt, .cycles = cycles};
      p.noise.vestibular.scale_deg = 0.0;
    });
  };
  std::vector<double> ramp;
  for (int k = 0; k <= 1000; ++k) ramp.push_back(0.04 * k);
  CHECK(joint(ramp, 1).empty());
  CHECK(contains(joint(ramp, 3), "measured tilt_deg: jumps by 40 degrees"));
  CHECK(contains(joint(ramp, 3), "cycles 1"));
  CHECK(joint({0.0, 1.0, 2.0, 3.0, 4.0, 5.0}, 2).empty());  // 5 steps
  CHECK(contains(joint({0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6}, 2), "by at most 0.1"));
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
