// Exported controllers with other steps than 1 ms: their self-test, and their torque beside the difference equation and
// beside the controller of 1 ms.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "base/text.hpp"
#include "sim/simulate.hpp"
#include "sim/streams.hpp"
#include "tests/tools/firmware/models.hpp"
#include "tools/firmware/balance.hpp"
#include "tools/firmware/controller.hpp"

namespace decid::tools {
namespace {

using namespace test;

constexpr double seconds = 6.0;

/// Returns the inputs of the controller at a time: sway and rate of the body, and the support's rate, all of 0.5 Hz.
std::array<double, 3> sensed(double time_s) {
  const double w = sim::pi, angle = w * time_s;
  return {0.01 * std::sin(angle), 0.01 * w * std::cos(angle), 0.02 * std::cos(angle + 0.7)};
}

/// Returns the torque of each step by the equations of sim/family.hpp, in N m and with Euler's steps. The estimate of
/// the platform's tilt and the tilt are sums of their own here; the controller keeps their difference only.
std::vector<double> expected_torque(const sim::BodyModel& model, const sim::Parameters& p, int steps_per_second) {
  using enum sim::Coefficient;
  const sim::Coefficients of = model.family.coefficients(p);
  const double h = 1.0 / steps_per_second, late = of[delay] * steps_per_second;
  const auto whole = static_cast<std::size_t>(late + 1e-9);
  const double fraction = std::max(0.0, late - static_cast<double>(whole));
  const bool is_whole = fraction < 1e-9;
  double estimate = 0.0, platform = 0.0, slow_angle = 0.0, torque_angle = 0.0, delayed = 0.0;
  std::vector<double> u, all;
  for (int step = 0; step < static_cast<int>(seconds * steps_per_second); ++step) {
    const auto [a, a_rate, f_rate] = sensed(step * h);
    const double estimate_rate = of[tilt] * (f_rate - std::clamp(f_rate, -of[theta], of[theta]));
    const double slow_rate = of[slow] * a - slow_angle / model.family.slow_time_s;
    const double torque_rate = of[torque] * delayed / sim::Body{}.mgh() - torque_angle / model.family.torque_time_s;
    const double v = of[position] * (a - platform) + estimate + of[gravity] * a + slow_angle + torque_angle;
    const double v_rate =
        of[position] * (a_rate - f_rate) + estimate_rate + of[gravity] * a_rate + slow_rate + torque_rate;
    u.push_back(of[kp] * v + of[kd] * v_rate);
    estimate += h * estimate_rate;
    platform += h * f_rate;
    slow_angle += h * slow_rate;
    torque_angle += h * torque_rate;
    const std::size_t now = u.size() - 1;
    delayed = 0.0;
    if (is_whole && now >= whole) delayed = u[now - whole];
    if (!is_whole && now > whole) delayed = (1.0 - fraction) * u[now - whole] + fraction * u[now - whole - 1];
    all.push_back(-delayed);
  }
  return all;
}

/// Returns the torque of each step of an exported controller whose self-test passes.
std::vector<double> exported_torque(const sim::BodyModel& model, const sim::Parameters& p, int steps_per_second) {
  const Folder folder;
  std::string options = " --controller " + model.name + format(" --step %.17g", 1.0 / steps_per_second);
  for (std::size_t i = 0; i < model.parameters.size(); ++i)
    if (model.parameters[i].name != "Nv") options += format(" --%s %.17g", model.parameters[i].option.c_str(), p[i]);
  run_ok("export controller --name controller --quiet" + options + " -o " + folder / "c");
  std::vector<double> inputs;
  for (int step = 0; step < static_cast<int>(seconds * steps_per_second); ++step)
    for (const double value : sensed(step * (1.0 / steps_per_second))) inputs.push_back(value);
  test::write_text(folder / "in.bin", {reinterpret_cast<const char*>(inputs.data()), inputs.size() * sizeof(double)});
  test::write_text(folder / "main.c", std::string("#include <stdio.h>\n#include \"controller.h\"\n") + R"(
static controller_state state;
int main(int count, char** files) {
  FILE *in, *out;
  double of[3], torque;
  if (count != 3) return 2;
  in = fopen(files[1], "rb");
  out = fopen(files[2], "wb");
  if (in == NULL || out == NULL) return 3;
  if (controller_self_test(&state) != CONTROLLER_OK) return 4;
  if (controller_begin(&state, NULL) != CONTROLLER_OK) return 5;
  while (fread(of, sizeof of, 1, in) == 1) {
    if (controller_step(&state, of[0], of[1], of[2], 0.0, &torque) != CONTROLLER_OK) return 6;
    if (fwrite(&torque, sizeof torque, 1, out) != 1) return 7;
  }
  return (fclose(out) == 0) ? 0 : 8;
}
)");
  const std::string c = folder / "c";
  compile(c99 + "-I " + c + " " + c + "/controller.c " + folder / "main.c" + " -o " + folder / "main");
  REQUIRE(shell(folder / "main" + " " + folder / "in.bin" + " " + folder / "out.bin") == 0);
  const std::string bytes = test::read_text(folder / "out.bin");
  std::vector<double> torque(bytes.size() / sizeof(double));
  std::memcpy(torque.data(), bytes.data(), torque.size() * sizeof(double));
  return torque;
}

double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double value : values) most = std::max(most, std::abs(value));
  return most;
}

void check_step(const sim::BodyModel& model, const sim::Parameters& p) {
  CAPTURE(model.name);
  const std::vector<double> at_1_ms = exported_torque(model, p, 1000), at_2_ms = exported_torque(model, p, 500);
  for (const std::vector<double>* const torque : {&at_1_ms, &at_2_ms}) {
    const int steps_per_second = torque == &at_1_ms ? 1000 : 500;
    CAPTURE(steps_per_second);
    const std::vector<double> expected = expected_torque(model, p, steps_per_second);
    REQUIRE(torque->size() == expected.size());
    double worst = 0.0;
    for (std::size_t k = 0; k < expected.size(); ++k) worst = std::max(worst, std::abs((*torque)[k] - expected[k]));
    CHECK(worst < 1e-9 * largest(expected));  // rounding of sums of 6000 terms
  }
  // From a delay on, when both have commands. Euler's sums differ by half a millisecond of what they sum, up to 7e-4 of
  // the torque here, at 0.5 Hz, and the delay's interpolation by (w h)^2 / 8 = 5e-6.
  const double delay_s = model.family.coefficients(p)[sim::Coefficient::delay];
  const auto first = static_cast<std::size_t>(delay_s * 500.0) + 2;
  const double most = largest(at_1_ms);
  CHECK(most > 5.0);
  double worst = 0.0;
  for (std::size_t k = first; k < at_2_ms.size(); ++k) worst = std::max(worst, std::abs(at_2_ms[k] - at_1_ms[2 * k]));
  CHECK(worst < 1e-3 * most);
  CHECK(worst > 0.0);
}

}  // namespace

TEST_CASE("the body of a controller's self-test has the simulator's bits at 1 ms") {
  for (const sim::BodyModel* model : {&sim::single_pendulum(), &sim::dec2015(), &sim::independent_channels()}) {
    CAPTURE(model->name);
    sim::Protocol protocol = sim::short_protocol();
    protocol.experiment.body_model = model;
    protocol.standing_s = 0.0;
    const sim::Simulator simulator(protocol);
    const sim::Parameters p = protocol.family().without_noise(model->parameters.middle());
    std::vector<double> sway(static_cast<std::size_t>(simulator.samples()));
    REQUIRE(simulator.run(p, Random(0, sim::streams::vestibular_noise, 0), sway).valid);
    const sim::Stimulus& stimulus = simulator.stimulus();
    const std::vector<double> mine =
        balance(protocol.family(), protocol.family().coefficients(p), protocol.experiment.body, stimulus, 1000).sway;
    const auto apart = static_cast<std::size_t>(protocol.experiment.steps_per_sample() / stimulus.interval_steps);
    REQUIRE(mine.size() >= sway.size() * apart);
    std::size_t different = 0;
    for (std::size_t k = 0; k < sway.size(); ++k) different += mine[k * apart] == sway[k] ? 0 : 1;
    CHECK(different == 0);
  }
}

TEST_CASE("the peak torque of a trial balances the body, and does not depend on the step") {
  const sim::Protocol protocol = sim::default_protocol();
  const sim::Body& body = protocol.experiment.body;
  const sim::Parameters p = protocol.family().without_noise(protocol.experiment.parameters().middle());
  const sim::Simulator simulator(protocol);
  const auto balanced = [&](int steps_per_second) {
    return balance(protocol.family(), protocol.family().coefficients(p), body,
                   stimulus_at(simulator.stimulus(), steps_per_second), steps_per_second);
  };
  const Balanced fine = balanced(1000);
  // J a'' = m g h sin(a) + torque - Kp_pass (a - f) - Kd_pass (a' - f'), with differences over 10 ms.
  const sim::Stimulus stimulus = stimulus_at(simulator.stimulus(), 1000);
  const double h = stimulus.interval_steps / 1000.0;
  double peak = 0.0;
  for (std::size_t k = 1; k + 1 < fine.sway.size(); ++k) {
    const double a = fine.sway[k], rate = (fine.sway[k + 1] - fine.sway[k - 1]) / (2.0 * h);
    const double bend = (fine.sway[k + 1] - 2.0 * a + fine.sway[k - 1]) / (h * h);
    const double tilt_rate = 0.5 * (stimulus.rate_rad_s[k] + stimulus.rate_rad_s[k - 1]);
    peak =
        std::max(peak, std::abs(body.inertia_kgm2 * bend - body.mgh() * std::sin(a) +
                                p[sim::Kp_pass] * (a - stimulus.tilt_rad[k]) + p[sim::Kd_pass] * (rate - tilt_rate)));
  }
  CHECK(fine.peak_active_torque_nm > 5.0);
  CHECK(std::abs(peak / fine.peak_active_torque_nm - 1.0) < 0.02);
  CHECK(std::abs(balanced(500).peak_active_torque_nm / fine.peak_active_torque_nm - 1.0) < 0.01);
}

TEST_CASE("a stimulus at another step is the same, straight within 10 ms") {
  const sim::Simulator simulator(sim::short_protocol());
  for (const int steps_per_second : {2000, 1000, 500, 300, 125, 100}) {
    CAPTURE(steps_per_second);
    const sim::Stimulus stimulus = stimulus_at(simulator.stimulus(), steps_per_second);
    const double interval_s = static_cast<double>(stimulus.interval_steps) / steps_per_second;
    CHECK(interval_s <= 0.0101);
    REQUIRE(stimulus.tilt_rad.size() == stimulus.rate_rad_s.size());
    double worst = 0.0;
    for (std::size_t i = 0; i < stimulus.tilt_rad.size(); i += 17) {
      const int step = static_cast<int>(static_cast<double>(i) * interval_s * 1000.0);  // rounded down to 1 ms
      if (step >= simulator.samples() * 10) break;
      worst = std::max(worst, std::abs(stimulus.tilt_rad[i] - simulator.stimulus().tilt_at(step)));
    }
    CHECK(worst < 0.001 * largest(stimulus.rate_rad_s) + 1e-12);
  }
}

TEST_CASE("a controller of 2 ms has the torque of its difference equation, and of the controller of 1 ms") {
  sim::Parameters p = {755.5, 276.9, 151.0, 100.7, 0.15, 0.0016, 0.1};
  check_step(sim::single_pendulum(), p);
  p[sim::Delay] = 0.0507;  // between two steps of either
  check_step(sim::single_pendulum(), p);
  check_step(sim::dec2015(), sim::dec2015().parameters.middle());
  check_step(sim::independent_channels(), sim::independent_channels().parameters.middle());
}

TEST_CASE("controllers of other steps keep the bits of their self-test, and know their step") {
  const Folder folder;
  sim::Parameters p = sim::single_pendulum().parameters.middle();
  for (const int steps_per_second : {2000, 300, 100}) {
    CAPTURE(steps_per_second);
    p[sim::Delay] = steps_per_second == 100 ? 0.004 : 0.1453;  // also a delay of less than a step
    const std::vector<double> torque = exported_torque(sim::single_pendulum(), p, steps_per_second);
    CHECK(torque.size() == static_cast<std::size_t>(seconds * steps_per_second));
  }
  run_ok("export controller --name c --quiet --step 0.0033333 -o " + folder / "c");
  const std::string header = test::read_text(folder / "c/c.h");
  CHECK(contains(header, "#define C_STEPS_PER_SECOND 300\n"));
  CHECK(contains(header, format("#define C_STEP_S %.17g\n", 1.0 / 300)));
  CHECK(contains(header, "#define C_DELAY_STEPS 302\n"));
}

TEST_CASE("a step is from 0.5 to 10 ms, with a whole number per second") {
  CHECK(steps_per_second_of(0.001) == 1000);
  CHECK(steps_per_second_of(0.0005) == 2000);
  CHECK(steps_per_second_of(0.01) == 100);
  CHECK(steps_per_second_of(0.00333333) == 300);
  for (const double step_s : {0.0, -0.001, 0.0004, 0.0101, 0.003, 0.0017, std::nan("")}) {
    CAPTURE(step_s);
    check_error([&] { steps_per_second_of(step_s); }, Code::setting_out_of_range, "--step");
  }
}

}  // namespace decid::tools
