// Exported controllers: the sway of whole trials, to the bit, beside the simulator's.
#include <array>
#include <cmath>

#include "base/text.hpp"
#include "sim/lanes.hpp"
#include "sim/streams.hpp"
#include "tests/tools/firmware/models.hpp"

namespace decid::tools {
namespace {

using namespace test;

/// Returns the input of controller_harness.c.
std::vector<double> trial_for_harness(const sim::Simulator& simulator, const sim::Parameters& p, const Random& noise) {
  const sim::Protocol& protocol = simulator.protocol();
  const sim::StepConstants course = sim::make_step_constants(protocol.experiment, simulator.stimulus());
  const std::array<double, 3> sine = sim::sine_coefficients_for(protocol.experiment.body);
  const auto samples = static_cast<std::size_t>(simulator.samples());
  const std::size_t intervals = simulator.stimulus().rate_rad_s.size() / samples;
  using enum sim::Coefficient;
  const sim::Coefficients of = protocol.family().coefficients(p);
  const bool is_static = of[slow] == 0.0 && of[torque] == 0.0;
  std::vector<double> trial{course.step_s / protocol.experiment.body.inertia_kgm2,
                            protocol.experiment.body.mgh(),
                            sine[0],
                            sine[1],
                            sine[2],
                            of[kp_pass],
                            of[kd_pass],
                            static_cast<double>(samples),
                            static_cast<double>(course.steps_per_sample),
                            static_cast<double>(intervals),
                            course.unit_gains ? 0.5 : of[tilt],
                            is_static ? of[position] + of[sim::Coefficient::gravity] : std::nan("")};
  for (std::size_t i = 0; i < samples * intervals; ++i) {
    trial.push_back(simulator.stimulus().tilt_rad[i]);
    trial.push_back(simulator.stimulus().rate_rad_s[i]);
  }
  std::vector<double> noise_rate(samples + 1, 0.0);
  if (of[nv] > 0.0) sim::VestibularNoiseMaker(protocol).velocity(of[nv], noise, noise_rate);
  trial.insert(trial.end(), noise_rate.begin(), noise_rate.end());
  return trial;
}

std::string as_bytes(const std::vector<double>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double)};
}

/// Shortest texts that are these very numbers.
std::string options_of(const sim::BodyModel& model, const sim::Parameters& p) {
  std::string text = " --controller " + model.name;
  for (std::size_t i = 0; i < model.parameters.size(); ++i)
    if (model.parameters[i].name != "Nv") text += format(" --%s %.17g", model.parameters[i].option.c_str(), p[i]);
  return text;
}

void check_controller(const sim::Parameters& parameters, const std::string& protocol_name, const std::string& compiler,
                      const sim::BodyModel& model = sim::single_pendulum()) {
  CAPTURE(compiler);
  CAPTURE(model.name);
  const Folder folder;
  sim::Protocol protocol = protocol_name == "short" ? sim::short_protocol() : sim::default_protocol();
  protocol.experiment.body_model = &model;
  const sim::Simulator simulator(protocol);
  const Random noise(5, sim::streams::vestibular_noise, 3);
  std::vector<double> sway(static_cast<std::size_t>(simulator.samples()));
  REQUIRE(simulator.run(parameters, noise, sway).valid);
  test::write_text(folder / "trial.bin", as_bytes(trial_for_harness(simulator, parameters, noise)));
  run_ok("export controller --name controller --quiet --protocol " + protocol_name + options_of(model, parameters) +
         " -o " + folder / "c");
  const std::string c = folder / "c";
  compile(compiler + " -I " + c + " -c " + c + "/controller.c -o " + folder / "c.o");
  REQUIRE(shell(std::string(DECID_C_COMPILER) + " -std=c99 -ffp-contract=off -O1 -I " + c + " " +
                DECID_SOURCE_DIR "/tests/tools/firmware/controller_harness.c " + folder / "c.o" + " -lm -o " +
                folder / "harness") == 0);
  REQUIRE(shell(folder / "harness" + " " + folder / "trial.bin" + " " + folder / "sway.bin") == 0);
  CHECK(test::read_text(folder / "sway.bin") == as_bytes(sway));
}

}  // namespace

TEST_CASE("an exported controller sways as the simulator's, to the bit") {
  sim::Parameters p = sim::single_pendulum().parameters.middle();
  check_controller(p, "default", c99);
  p[sim::Delay] = 0.1;  // whole milliseconds
  check_controller(p, "short", c99);
  p[sim::Delay] = 0.0;
  p[sim::Nv] = 0.0;
  p[sim::Theta] = 0.0;
  check_controller(p, "default", c99);
  p = {755.5, 276.9, 151.0, 100.7, 0.15, 0.0016, 0.0004};  // a delay of less than a step
  check_controller(p, "default", c99);
  p[sim::Delay] = 0.1453;
  if (test::have("clang++-14")) check_controller(p, "default", "clang++-14 -x c++ -std=c++17 -O2");
  if (test::have("gcc")) check_controller(p, "default", "gcc -std=gnu99 -O0");
}

TEST_CASE("exported controllers with gains, slow and torque feedback: the simulator's sway, to the bit") {
  sim::Parameters p = sim::dec2015().parameters.middle();
  p[sim::Nv] = 0.0;
  check_controller(p, "default", c99, sim::dec2015());
  p[sim::Nv] = 0.3;
  p[8] = 0.5;   // the tilt's gain: a power of two, by which the harness can divide the noise
  p[10] = 0.0;  // no slow feedback
  check_controller(p, "short", c99, sim::dec2015());
  if (test::have("clang++-14")) check_controller(p, "short", "clang++-14 -x c++ -std=c++17 -O2", sim::dec2015());
  p = sim::independent_channels().parameters.middle();
  p[2] = 0.5;
  check_controller(p, "default", c99, sim::independent_channels());
  p[3] = 0.0;  // no torque feedback
  check_controller(p, "short", "gcc -std=gnu99 -O0", sim::independent_channels());
}

TEST_CASE("an exported controller's tilt error is what its threshold hid, and 0 sets the body upright again") {
  const Folder folder;
  run_ok("export controller --theta 0.0026 --name controller --quiet -o " + folder / "dec");
  run_ok("export controller --controller dec2015 --name controller --quiet -o " + folder / "gains");
  // 2 degrees up at 5 degrees/s, back at 0.05.
  const std::string main = std::string("#include <math.h>\n#include <stddef.h>\n#include \"controller.h\"\n") + R"(
static controller_state state;
static double sway, rate, tilt;
static int play(double support, int steps) {
  double torque = 0.0;
  for (; steps > 0; --steps) {
    if (controller_step(&state, sway, rate, support, 0.0, &torque) != CONTROLLER_OK) return 0;
    torque += controller_passive(&state, sway - tilt, rate - support);
    rate += 0.001 * (CONTROLLER_MGH_NM_RAD * sin(sway) + torque) / CONTROLLER_INERTIA_KGM2;
    sway += 0.001 * rate;
    tilt += 0.001 * support;
  }
  return 1;
}
int main(void) {
  const double degree = 0.017453292519943295;
  double expected;
  int i;
  if (controller_begin(&state, NULL) != CONTROLLER_OK || !play(5.0 * degree, 400) || !play(-0.05 * degree, 40000)) return 1;
  expected = TILT_GAIN * (2.0 * degree - 0.4 * controller_identified.theta);
  if (fabs(tilt) > 1e-9 || fabs(controller_tilt_error(&state) - expected) > 1e-9) return 2;
  if (SLOW) return 0; /* slow feedback balances the lean */
  if (!play(0.0, 10000) || fabs(sway + 1.5 * degree) > 0.1 * degree) return 3;
  for (i = 999; i >= 0; --i)
    if (controller_set_tilt_error(&state, 0.001 * i * expected) != CONTROLLER_OK || !play(0.0, 2)) return 4;
  if (!play(0.0, 10000)) return 5;
  return (fabs(sway) < 0.001 * degree && controller_tilt_error(&state) == 0.0) ? 0 : 6;
}
)";
  test::write_text(folder / "main.c", main);
  for (const auto& [c, define] : {std::array<std::string, 2>{"dec", " -DTILT_GAIN=1.0 -DSLOW=0"},
                                  {"gains", " -DTILT_GAIN=controller_identified.tilt_gain -DSLOW=1"}}) {
    const std::string& exported = c;
    CAPTURE(exported);
    REQUIRE(shell(c99 + define + " -I " + folder / c + " " + folder / "main.c" + " " + folder / c +
                  "/controller.c -lm -o " + folder / "main") == 0);
    CHECK(shell(folder / "main") == 0);
  }
}

}  // namespace decid::tools
