// Tests of sim/protocol/protocol.hpp: every bound of the settings.
#include "sim/protocol/protocol.hpp"

#include <cmath>
#include <functional>
#include <limits>
#include <locale>
#include <vector>

#include "base/error.hpp"
#include "sim/noise.hpp"
#include "sim/protocol/detail/checker.hpp"
#include "sim/protocol/protocol_json.hpp"
#include "tests/helpers.hpp"

using namespace decid::sim;
using namespace decid::test;

namespace {

const auto not_a_number = std::numeric_limits<double>::quiet_NaN();
const auto infinity = std::numeric_limits<double>::infinity();

}  // namespace

TEST_CASE("setting_text: a decimal point whatever locale the host has set for streams") {
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
  const std::string half = setting_text(0.5), large = setting_text(12'100.0), third = setting_text(1.0 / 3.0);
  std::locale::global(before);
  CHECK(half == "0.5");
  CHECK(large == "12100");
  CHECK(third == "0.3333333333");
}

TEST_CASE("Protocol::validate: every bound") {
  // `setting`: part of what the error says.
  const auto refused = [](const char* setting, const std::function<void(Protocol&)>& spoil) {
    Protocol protocol;
    spoil(protocol);
    check_error([&] { protocol.validate(); }, decid::Code::setting_out_of_range, setting);
  };
  struct Row {
    const char* setting;
    void (*set)(Protocol&, double);
    std::vector<double> wrong;
  };
  const auto nan = not_a_number;
  const std::vector<Row> rows{
      {"sequence state_s", [](Protocol& p, double v) { p.sequence().state_s = v; }, {0.0, 0.2505, nan, infinity}},
      {"sequence amplitude_deg", [](Protocol& p, double v) { p.sequence().amplitude_deg = v; }, {0.0, -1.0, 46.0, nan}},
      {"sequence offset_s", [](Protocol& p, double v) { p.sequence().offset_s = v; }, {-0.001, 60.5, 1.0005, nan}},
      {"sequence cycles", [](Protocol& p, double v) { p.sequence().cycles = static_cast<int>(v); }, {0, 2147483647}},
      {"sequence lead_in_s", [](Protocol& p, double v) { p.sequence().lead_in_s = v; }, {-1.0, 0.0005, nan}},
      {"sequence lead_out_s", [](Protocol& p, double v) { p.sequence().lead_out_s = v; }, {infinity, 1.0001}},
      {"at most 3600 s", [](Protocol& p, double v) { p.sequence().cycles = static_cast<int>(v); }, {60}},
      {"at most 3600 s", [](Protocol& p, double v) { p.sequence().state_s = v; }, {3600.0}},
      {"at most 3600 s", [](Protocol& p, double v) { p.sequence().lead_in_s = v; }, {3600.0}},
      {"number of samples", [](Protocol& p, double v) { p.sequence().lead_out_s = v; }, {0.005}},
      {"sample_rate_hz", [](Protocol& p, double v) { p.experiment.sample_rate_hz = v; }, {0.0, 62.5, 30, 2000, nan}},
      {"mass_kg", [](Protocol& p, double v) { p.experiment.body.mass_kg = v; }, {0.0, 1000.0}},
      {"com_height_m", [](Protocol& p, double v) { p.experiment.body.com_height_m = v; }, {-1.0, 6.0}},
      {"inertia_kgm2", [](Protocol& p, double v) { p.experiment.body.inertia_kgm2 = v; }, {nan, 1e5}},
      {"scale_deg", [](Protocol& p, double v) { p.noise.vestibular.scale_deg = v; }, {-0.1, infinity}},
      {"high_hz", [](Protocol& p, double v) { p.noise.vestibular.high_hz = v; }, {10.001, nan}},
      {"low_hz", [](Protocol& p, double v) { p.noise.vestibular.low_hz = v; }, {0.0, 1.1}},
      {"exponent", [](Protocol& p, double v) { p.noise.vestibular.exponent = v; }, {-0.1, 4.1}},
      // 200.11 s are 20,011 samples, a prime.
      {"period_s",
       [](Protocol& p, double v) { p.noise.vestibular.period_s = v; },
       {120.99, 12'100.01, -121.0, 121.005, 200.11, nan}}};
  for (const Row& row : rows)
    for (const double value : row.wrong) refused(row.setting, [&](Protocol& p) { row.set(p, value); });
  for (const auto& [low, high] : {std::pair(-0.1, 0.1), {0.2, 0.1}, {0.0, 0.1}, {0.1, infinity}, {nan, 0.1}}) {
    const SensorNoise noise{low, high};
    refused("sensor_noise_deg", [&](Protocol& p) { p.noise.sensor = noise; });
  }
  const auto sequence = [&](const char* setting, const std::vector<int>& feedback, const std::vector<int>& start) {
    refused(setting, [&](Protocol& p) { p.sequence().feedback = feedback, p.sequence().start = start; });
  };
  const std::vector<int> feedback = Sequence{}.feedback, start = Sequence{}.start;
  sequence("sequence", {1}, {1});
  sequence("sequence", std::vector<int>(13, 1), std::vector<int>(13, 1));
  sequence("sequence", feedback, {1, 0, 0});
  sequence("sequence", {0, 0, 1, -1, 0}, start);
  sequence("sequence feedback", {3, 0, 1, -1, -1}, start);
  sequence("sequence feedback", {-3, 0, 1, -1, -1}, start);
  sequence("sequence feedback", {0, 1}, {1, 1});  // 1 1 1 ...: a ramp
  sequence("sequence start", feedback, {2, 3, 2, 0, 2});
  sequence("sequence start", feedback, {2, -1, 2, 0, 2});
  sequence("sequence start", feedback, {0, 0, 0, 0, 0});
}

TEST_CASE("Protocol: standing") {
  const auto standing = [](double standing_s, double rate_hz = 100.0) {
    Protocol protocol;
    protocol.experiment.sample_rate_hz = rate_hz;
    protocol.standing_s = standing_s;
    return [protocol] { protocol.validate(); };
  };
  const auto refused = [](const auto& call) { check_error(call, decid::Code::setting_out_of_range, "standing_s"); };
  for (const double right : {0.0, 0.01, 10.0, 59.99, 60.0}) CHECK_NOTHROW(standing(right)());
  for (const double wrong : {-1.0, -0.01, 60.01, 0.005, 0.0101, not_a_number, infinity}) refused(standing(wrong));
  refused(standing(0.05, 10.0));
  CHECK_NOTHROW(standing(0.05, 20.0)());

  Protocol protocol;
  protocol.standing_s = 10.0;
  CHECK(protocol.ideal().standing_s == 10.0);
  CHECK(protocol.experiment == Protocol{}.experiment);
  CHECK(protocol.duration_s() == 121.0);
  CHECK(protocol.with_time_before().duration_s() == 131.0);
  CHECK(protocol.with_time_before().experiment.lead_in_s() == 10.0);
  CHECK(protocol.with_time_before().standing_s == 0.0);
  Protocol moved = protocol;
  moved.moved_before = true;
  CHECK_NOTHROW(moved.validate());
  CHECK(moved.with_time_before().duration_s() == 191.5);
  CHECK_FALSE(moved.with_time_before().moved_before);
  CHECK(moved.experiment.duration_s() == 121.0);
  CHECK(moved.from_rest().with_time_before().duration_s() == 121.0);
  CHECK(protocol_from_json(to_json(moved), "p").moved_before);
  CHECK(to_json(protocol).find("moved_before") == std::string::npos);
  moved.sequence().lead_in_s = 1.0;
  check_error([&] { moved.validate(); }, decid::Code::setting_out_of_range, "moved_before");
  std::vector<double> ramp(2000);  // whose next cycle would begin with a jump
  for (std::size_t k = 0; k < ramp.size(); ++k) ramp[k] = 0.001 * static_cast<double>(k);
  moved.experiment.stimulus = MeasuredTilt{ramp};
  check_error([&] { moved.validate(); }, decid::Code::setting_out_of_range, "moved_before");

  // A period that is long enough stays; another is twice what is simulated.
  CHECK(protocol.with_time_before().noise_period_s() == 242.0);
  protocol.noise.vestibular.period_s = 131.0;
  CHECK(protocol.with_time_before().noise_period_s() == 131.0);
  protocol.noise.vestibular.period_s = 130.99;
  CHECK(protocol.with_time_before().noise_period_s() == 262.0);
  protocol.noise.vestibular.period_s = 121.0;
  CHECK(protocol.with_time_before().noise_period_s() == 262.0);

  // Twice what is simulated must be a length that can be transformed: 12,109 is a prime.
  protocol.standing_s = 0.09;
  refused([&] { protocol.validate(); });
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

TEST_CASE("Experiment: equal ones; noise and name may differ") {
  const Protocol a;
  Protocol b;
  b.name = "other";
  b.noise.vestibular.scale_deg = 1.0;
  b.noise.sensor = {0.1, 0.2};
  CHECK(a.experiment == b.experiment);
  b.sequence().start[1] = 1;
  CHECK(a.experiment != b.experiment);
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
    CHECK(near(lighter[p].low, info.low * (info.scales_with_mgh ? 0.5 : 1.0), 1e-12 * std::abs(info.high)));
    CHECK(near(lighter[p].high, info.high * (info.scales_with_mgh ? 0.5 : 1.0), 1e-12 * info.high));
  }
  CHECK(near(lighter[decid::sim::Kp].high / protocol.experiment.body.mgh(),
             protocol.parameters()[decid::sim::Kp].high / mgh, 1e-12));
}
