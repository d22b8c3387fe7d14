// The DEC controller as C files: see controller.hpp.
#include "tools/firmware/controller.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

#include "base/error.hpp"
#include "base/text.hpp"
#include "embedded/firmware_arithmetic.hpp"
#include "embedded/firmware_controller.hpp"
#include "embedded/firmware_controller_header.hpp"
#include "sim/lanes.hpp"
#include "sim/streams.hpp"
#include "tools/firmware/c_text.hpp"

namespace decid::tools {
namespace {

constexpr int test_seconds = 3;

/// Members of the C structure that only controllers with gains of their own have.
constexpr const char* gain_members = R"(  double servo;        /* gain of the ankle angle, 1 */
  double tilt_gain;    /* of the estimated tilt, 1 */
  double gravity_gain; /* of the body's angle, 1 */
  double slow_gain;    /* slow feedback of the body's angle, 1/s */
  double torque_gain;  /* positive feedback of the active torque, 1/s */
)";
constexpr const char* gain_state = R"(  double reach, tilt, tilt_over_servo, slow_gain, torque_gain;
  double slow, torque, active;
)";

std::string parameter_table(const sim::Coefficients& of, bool unit_gains) {
  using enum sim::Coefficient;
  std::vector<sim::Coefficient> members{kp, kd, kp_pass, kd_pass, theta, delay};
  if (!unit_gains) members.insert(members.end(), {position, tilt, sim::Coefficient::gravity, slow, torque});
  std::string list;
  for (const sim::Coefficient member : members) list += (list.empty() ? "" : ", ") + literal(of[member]);
  return "const DECID_FW_parameters DECID_FW_identified = {" + list + "};\n\n";
}

}  // namespace

std::uint64_t hash_values(std::span<const double> values) {
  std::uint64_t hash = 14695981039346656037U;
  for (const double value : values) hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 1099511628211U;
  return hash;
}

FirmwareFiles controller_files(const sim::Parameters& parameters, const sim::Protocol& protocol,
                               const std::string& name, const std::string& origin) {
  if (protocol.gravity_dead_band_deg > 0.0)
    throw Error(Code::not_supported, "protocol " + protocol.name,
                "has a gravity dead band, which exported controllers do not have", "leave gravity_dead_band_deg out");
  sim::Protocol from_rest = protocol;
  from_rest.standing_s = 0.0;  // so begins the self-test
  const sim::Simulator simulator(from_rest);
  const sim::Parameters noise_free = protocol.family().without_noise(parameters);
  std::vector<double> sway(static_cast<std::size_t>(simulator.samples()));
  const sim::Outcome outcome = simulator.run(noise_free, Random(0, sim::streams::vestibular_noise, 0), sway);
  if (!outcome.valid)
    throw Error(Code::body_falls, "export controller",
                format("with these parameters the body falls after %.2f s", outcome.end_s),
                "change the gains or lower the delay");
  const sim::Stimulus& stimulus = simulator.stimulus();
  const int samples =
      std::min(simulator.samples(), static_cast<int>(test_seconds * protocol.experiment.sample_rate_hz));
  const int intervals = samples * protocol.experiment.steps_per_sample() / stimulus.interval_steps;
  const auto first = [&](const std::vector<double>& values) {
    return std::vector<double>(values.begin(), values.begin() + intervals);
  };
  const std::uint64_t hash = hash_values(std::span(sway).first(static_cast<std::size_t>(samples)));

  const sim::Body& body = protocol.experiment.body;
  std::string header =
      "/* " + origin +
      format(
          "\n   For a body of %.6g kg whose centre of mass is %.6g m above the ankles: m g h %.6g N m/rad."
          "\n   How to use it: docs/guide/firmware.md of decid. */\n",
          body.mass_kg, body.com_height_m, body.mgh());
  header += embedded::firmware_controller_header();
  const int delay_steps = static_cast<int>(sim::longest_delay_s * sim::steps_per_second) + 2;
  header = replaced(header, "@CONSTANTS@",
                    define("DECID_FW_STEPS_PER_SECOND", sim::steps_per_second) +
                        define_double("DECID_FW_LONGEST_DELAY_S", sim::longest_delay_s) +
                        define("DECID_FW_DELAY_STEPS", delay_steps) + define_double("DECID_FW_MASS_KG", body.mass_kg) +
                        define_double("DECID_FW_COM_HEIGHT_M", body.com_height_m) +
                        define_double("DECID_FW_INERTIA_KGM2", body.inertia_kgm2) +
                        define_double("DECID_FW_MGH_NM_RAD", body.mgh()) +
                        define("DECID_FW_TEST_STEPS", samples * protocol.experiment.steps_per_sample()));

  const sim::StepConstants course = sim::make_step_constants(protocol.experiment, stimulus);
  header = replaced(header, "@GAINS@", course.unit_gains ? "" : gain_members);
  header = replaced(header, "@STATE@", course.unit_gains ? "" : gain_state);
  const std::array<double, 3> sine = sim::sine_coefficients_for(body);
  std::string source = "/* " + origin + R"(
   Plain C99, or C++. No library at all, no memory but what the caller gives. All numbers are IEEE 754; gcc outside of
   -std=c99 needs -ffp-contract=off, no compiler may have -ffast-math or -ffinite-math-only. The self-test tells if the
   bits are right. */
)";
  source += "#include \"" + name + ".h\"\n\n#include <float.h>\n#include <stddef.h>\n#include <stdint.h>\n\n";
  for (const char* unused : {"USES_SQUARE_ROOT", "USES_LOG", "USES_EXPONENTIAL", "USES_FMA_FLOAT", "USES_FLOAT_BITS"})
    source += define(unused, 0);
  source += define("USES_FMA_DOUBLE", 1) + define("USES_IS_FINITE", 1) +
            define_double("LARGEST_GAIN", std::numeric_limits<double>::max()) +
            // Half of the largest whose torque is finite: what rounding adds to it is less.
            define_double("LARGEST_COMMAND",
                          0.5 * std::numeric_limits<double>::max() * std::min(1.0, course.step_s / body.inertia_kgm2)) +
            define_double("STEP_OVER_INERTIA", course.step_s / body.inertia_kgm2) +
            define_double("BODY_MGH", body.mgh()) + define("UNIT_GAINS", course.unit_gains ? 1 : 0) +
            define_double("SINE_0", sine[0]) + define_double("SINE_1", sine[1]) + define_double("SINE_2", sine[2]) +
            define("STEPS_PER_SAMPLE", course.steps_per_sample) + define("STEPS_PER_INTERVAL", course.interval_steps) +
            define("TEST_INTERVALS", intervals) +
            format("#define TEST_HASH 0x%016llxU\n\n", static_cast<unsigned long long>(hash));
  if (!course.unit_gains)
    source += define_double("SLOW_LEAK", course.slow_leak) + define_double("TORQUE_LEAK", course.torque_leak) + "\n";
  source += embedded::firmware_arithmetic();
  source += "\n" + parameter_table(protocol.family().coefficients(parameters), course.unit_gains) +
            table("static const double test_tilt[]", first(stimulus.tilt_rad)) +
            table("static const double test_rate[]", first(stimulus.rate_rad_s)) + "\n";
  source += embedded::firmware_controller();
  return {with_name(header, name), with_name(source, name)};
}

}  // namespace decid::tools
