// The DEC controller as C files: see controller.hpp.
#include "tools/firmware/controller.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "base/text.hpp"
#include "embedded/firmware_angle.hpp"
#include "embedded/firmware_arithmetic.hpp"
#include "embedded/firmware_check.hpp"
#include "embedded/firmware_check_header.hpp"
#include "embedded/firmware_controller.hpp"
#include "embedded/firmware_controller_header.hpp"
#include "sim/streams.hpp"
#include "tools/firmware/balance.hpp"
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
/// Text of the header: the tilt error with such gains, the one that is right, and a limit without such gains.
constexpr const char* gain_tilt_error =
    "\n   Here it is tilt_gain times the tilt as estimated, less servo times the tilt.";
constexpr const char* gain_rezero =
    "With\n   (tilt_gain - servo) times the support's absolute angle the estimate is right.";
/// Text of the header: where the margins of other gains come from, with a check in C and without.
constexpr const char* other_gains_checked = "check\n   them with DECID_FW_check().";
constexpr const char* other_gains_unchecked =
    "CHECKS_GAINS\n   is 0 because this controller's take polynomials of higher degree, so export each set of gains "
    "with"
    "\n   decid, which states its margins.";
constexpr const char* passive_limit = ": GAIN_MARGIN_LOW is then at least\n   m g h / (2 kp + kp_pass)";
constexpr const char* test_of_check = " DECID_FW_check()\n   must find the header's margins.";
constexpr const char* unit_rezero = "With 0\n   the estimate is right, whatever the support's angle is.";

/// Returns what the self-test knows of the answers of DECID_FW_check: a border only if it is inside of what can be
/// asked.
std::string borders_of_check(const frf::StabilityMargins& margins) {
  constexpr double clearance = 1e-5;
  const double factor =
      margins.gain_low > 0.0 ? std::min(1.0 / margins.gain_low, margins.gain_high) : margins.gain_high;
  const bool tests_delay =
      margins.stable && margins.delay_s > clearance && margins.delay_s < frf::max_delay_margin_s - clearance;
  const bool tests_gain = margins.stable && factor > 1.0 + clearance && factor < frf::max_gain_margin - clearance;
  return std::string("#define CHECK_OF_IDENTIFIED ") + (margins.stable ? "DECID_FW_OK" : "DECID_FW_ERROR_UNSTABLE") +
         "\n" + define("TESTS_DELAY_MARGIN", tests_delay ? 1 : 0) + define("TESTS_GAIN_MARGIN", tests_gain ? 1 : 0) +
         define_double("NEARER_GAIN_MARGIN", factor);
}

std::string parameter_table(const sim::Coefficients& of, bool unit_gains) {
  using enum sim::Coefficient;
  std::vector<sim::Coefficient> members{kp, kd, kp_pass, kd_pass, theta, delay};
  if (!unit_gains) members.insert(members.end(), {position, tilt, sim::Coefficient::gravity, slow, torque});
  const std::string list = joined(members, ", ", [&](sim::Coefficient member) { return literal(of[member]); });
  return "const DECID_FW_parameters DECID_FW_identified = {" + list + "};\n\n";
}

/// The tilt that the self-test plays, and the hash of the sway that decid expects.
struct SelfTest {
  sim::Stimulus stimulus;
  int steps_per_sample = 1;  // of the hash
  std::uint64_t hash = 0;

  int intervals() const { return static_cast<int>(stimulus.tilt_rad.size()); }
  int steps() const { return intervals() * stimulus.interval_steps; }
};

[[noreturn]] void refuse_fall(double end_s) {
  throw Error(Code::body_falls, "export controller", format("with these parameters the body falls after %.2f s", end_s),
              "change the gains or lower the delay");
}

void shorten(sim::Stimulus& stimulus, int intervals) {
  stimulus.tilt_rad.resize(static_cast<std::size_t>(intervals));
  stimulus.rate_rad_s.resize(static_cast<std::size_t>(intervals));
}

/// Returns the test with the simulator's sway. Throws Error if the body falls.
SelfTest simulate_test(const sim::Simulator& simulator, const sim::Parameters& noise_free) {
  const sim::Protocol& protocol = simulator.protocol();
  std::vector<double> sway(static_cast<std::size_t>(simulator.samples()));
  const sim::Outcome outcome = simulator.run(noise_free, Random(0, sim::streams::vestibular_noise, 0), sway);
  if (!outcome.valid) refuse_fall(outcome.end_s);
  const sim::Stimulus& stimulus = simulator.stimulus();
  const int samples =
      std::min(simulator.samples(), static_cast<int>(test_seconds * protocol.experiment.sample_rate_hz));
  SelfTest test;
  test.stimulus = stimulus;
  test.steps_per_sample = protocol.experiment.steps_per_sample();
  shorten(test.stimulus, samples * test.steps_per_sample / stimulus.interval_steps);
  test.hash = hash_values(std::span(sway).first(static_cast<std::size_t>(samples)));
  return test;
}

/// Returns the test with the sway at another step.
SelfTest balance_test(const sim::Stimulus& stimulus, const Balanced& balanced, int steps_per_second) {
  SelfTest test;
  test.stimulus = stimulus;
  test.steps_per_sample = test.stimulus.interval_steps;
  shorten(test.stimulus, std::min(test.intervals(), test_seconds * steps_per_second / test.stimulus.interval_steps));
  test.hash = hash_values(std::span(balanced.sway).first(static_cast<std::size_t>(test.intervals())));
  return test;
}

double peak(const std::vector<double>& values) {
  double largest = 0.0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  return largest;
}

std::string limits_constants(const ControllerLimits& limits) {
  return define("DECID_FW_IS_STABLE", limits.margins.stable ? 1 : 0) +
         define_double("DECID_FW_DELAY_MARGIN_S", limits.margins.delay_s) +
         define_double("DECID_FW_GAIN_MARGIN_LOW", limits.margins.gain_low) +
         define_double("DECID_FW_GAIN_MARGIN_HIGH", limits.margins.gain_high) +
         define_double("DECID_FW_PEAK_TORQUE_NM", limits.peak_active_torque_nm);
}

/// Returns the lines of a comment.
std::string limits_comment(const ControllerLimits& limits) {
  std::string text;
  for (const std::string& line : limits_text(limits)) text += "\n   " + comment(line);
  return text;
}

/// A controller with its body, at its steps.
struct Loop {
  const sim::Body& body;
  const sim::Family& family;
  sim::Coefficients of;
  bool unit_gains;
  int steps_per_second;

  double step_s() const { return 1.0 / steps_per_second; }
};

std::string header_constants(const Loop& loop, const SelfTest& test) {
  const int delay_steps = static_cast<int>(sim::longest_delay_s * loop.steps_per_second) + 2;
  return define("DECID_FW_STEPS_PER_SECOND", loop.steps_per_second) + define_double("DECID_FW_STEP_S", loop.step_s()) +
         define_double("DECID_FW_LONGEST_DELAY_S", sim::longest_delay_s) + define("DECID_FW_DELAY_STEPS", delay_steps) +
         define_double("DECID_FW_MASS_KG", loop.body.mass_kg) +
         define_double("DECID_FW_COM_HEIGHT_M", loop.body.com_height_m) +
         define_double("DECID_FW_INERTIA_KGM2", loop.body.inertia_kgm2) +
         define_double("DECID_FW_MGH_NM_RAD", loop.body.mgh()) + define("DECID_FW_TEST_STEPS", test.steps());
}

/// Returns the header, with DECID_FW in its names.
std::string header_text(const Loop& loop, const ControllerLimits& limits, const SelfTest& test,
                        const std::string& origin) {
  const sim::Body& body = loop.body;
  std::string header =
      "/* " + origin +
      format(
          "\n   For a body of %.6g kg whose centre of mass is %.6g m above the ankles: m g h %.6g N m/rad."
          "\n   Simulated with this body and the parameters that this file was made with:",
          body.mass_kg, body.com_height_m, body.mgh()) +
      limits_comment(limits) + "\n   How to use it: docs/guide/firmware.md of decid. */\n";
  header += embedded::firmware_controller_header();
  header = replaced(header, "@CONSTANTS@", header_constants(loop, test));
  header =
      replaced(header, "@LIMITS@", limits_constants(limits) + define("DECID_FW_CHECKS_GAINS", loop.unit_gains ? 1 : 0));
  struct Choice {
    const char *mark, *unit_gains, *other_gains;
  };
  const std::string check(embedded::firmware_check_header());
  for (const Choice& choice : {Choice{"@OTHER_GAINS@", other_gains_checked, other_gains_unchecked},
                               {"@CHECK@", check.c_str(), ""},
                               {"@PASSIVE_LIMIT@", passive_limit, ""},
                               {"@TEST_OF_CHECK@", test_of_check, ""},
                               {"@GAINS@", "", gain_members},
                               {"@STATE@", "", gain_state},
                               {"@TILT_ERROR@", "", gain_tilt_error},
                               {"@REZERO@", unit_rezero, gain_rezero}})
    header = replaced(header, choice.mark, loop.unit_gains ? choice.unit_gains : choice.other_gains);
  return header;
}

constexpr const char* source_comment = R"(
   Plain C99, or C++. No library at all, no memory but what the caller gives. All numbers are IEEE 754; gcc outside of
   -std=c99 needs -ffp-contract=off, no compiler may have -ffast-math or -ffinite-math-only. The self-test tells if the
   bits are right. */
)";

/// Returns the constants that the source needs to be compiled.
std::string source_constants(const Loop& loop, const frf::StabilityMargins& margins, const SelfTest& test) {
  const double step_over_inertia = loop.step_s() / loop.body.inertia_kgm2;
  const std::array<double, 3> sine = sine_coefficients_at(loop.body, loop.steps_per_second);
  std::string text;
  for (const char* unused : {"USES_LOG", "USES_EXPONENTIAL", "USES_FMA_FLOAT", "USES_FLOAT_BITS"})
    text += define(unused, 0);
  text +=
      define("USES_SQUARE_ROOT", loop.unit_gains ? 1 : 0) + define("USES_FMA_DOUBLE", 1) + define("USES_IS_FINITE", 1) +
      define_double("LARGEST_GAIN", std::numeric_limits<double>::max()) +
      // Half of the largest whose torque is finite: what rounding adds to it is less.
      define_double("LARGEST_COMMAND", 0.5 * std::numeric_limits<double>::max() * std::min(1.0, step_over_inertia)) +
      define_double("STEP_OVER_INERTIA", step_over_inertia) + define_double("BODY_MGH", loop.body.mgh()) +
      define("UNIT_GAINS", loop.unit_gains ? 1 : 0);
  if (loop.unit_gains)
    text += define("USES_PHASE", 1) + define_double("LARGEST_DELAY_MARGIN_S", frf::max_delay_margin_s) +
            define_double("LARGEST_GAIN_MARGIN", frf::max_gain_margin) + borders_of_check(margins);
  text += define_double("SINE_0", sine[0]) + define_double("SINE_1", sine[1]) + define_double("SINE_2", sine[2]) +
          define("STEPS_PER_SAMPLE", test.steps_per_sample) +
          define("STEPS_PER_INTERVAL", test.stimulus.interval_steps) + define("TEST_INTERVALS", test.intervals()) +
          format("#define TEST_HASH 0x%016llxU\n\n", static_cast<unsigned long long>(test.hash));
  if (!loop.unit_gains)
    text += define_double("SLOW_LEAK", 1.0 / loop.family.slow_time_s) +
            define_double("TORQUE_LEAK", 1.0 / loop.family.torque_time_s) + "\n";
  return text;
}

/// Returns the source below its first #include, with DECID_FW in its names.
std::string source_text(const Loop& loop, const frf::StabilityMargins& margins, const SelfTest& test) {
  std::string source = "#include <float.h>\n#include <stddef.h>\n#include <stdint.h>\n\n";
  source += source_constants(loop, margins, test);
  source += embedded::firmware_arithmetic();
  source += "\n" + parameter_table(loop.of, loop.unit_gains) +
            table("static const double test_tilt[]", test.stimulus.tilt_rad) +
            table("static const double test_rate[]", test.stimulus.rate_rad_s) + "\n";
  source += embedded::firmware_controller();
  if (loop.unit_gains) {
    source += "\n";
    source += embedded::firmware_angle();
    source += embedded::firmware_check();
  }
  return source;
}

}  // namespace

std::uint64_t hash_values(std::span<const double> values) {
  std::uint64_t hash = 14695981039346656037U;
  for (const double value : values) hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 1099511628211U;
  return hash;
}

int steps_per_second_of(double step_s) {
  constexpr double rounding = 1e-4;  // of a step that was typed
  const double rate = 1.0 / step_s, whole = std::round(rate);
  if (!(step_s >= 0.0005 && step_s <= 0.01))
    throw Error(Code::setting_out_of_range, "--step", format("is %g s", step_s), "give 0.0005 to 0.01 s");
  if (std::abs(rate - whole) > rounding * whole)
    throw Error(Code::setting_out_of_range, "--step", format("is %g s, %.6g steps per second", step_s, rate),
                format("give a step with a whole number of steps per second, such as %.7g s", 1.0 / whole));
  return static_cast<int>(whole);
}

std::vector<std::string> limits_text(const ControllerLimits& limits) {
  const frf::StabilityMargins& margins = limits.margins;
  const auto up_to = [](double value, double max, const char* shown) {
    return (value < max ? "" : "at least ") + format(shown, value);
  };
  std::vector<std::string> lines{"the loop is UNSTABLE: a small lean grows without limit"};
  if (margins.stable)
    lines.front() = "delay margin " + up_to(1000.0 * margins.delay_s, 1000.0 * frf::max_delay_margin_s, "%.0f ms") +
                    " beyond the controller's delay; gain margin (factor of kp and kd) " +
                    format("%.2f to ", margins.gain_low) + up_to(margins.gain_high, frf::max_gain_margin, "%.2f");
  lines.push_back(format("active torque up to %.3g N m for the protocol's tilt of up to %.3g degrees (sway up to %.3g)",
                         limits.peak_active_torque_nm, limits.peak_tilt_rad / sim::rad_per_deg,
                         limits.peak_sway_rad / sim::rad_per_deg));
  return lines;
}

ControllerFiles controller_files(const sim::Parameters& parameters, const sim::Protocol& protocol,
                                 const std::string& name, const std::string& origin, int steps_per_second) {
  if (protocol.gravity_dead_band_deg > 0.0)
    throw Error(Code::not_supported, "protocol " + protocol.name,
                "has a gravity dead band, which exported controllers do not have", "leave gravity_dead_band_deg out");
  const sim::Simulator simulator(protocol.from_rest());  // so begins the self-test
  const sim::Family& family = protocol.family();
  const sim::Body& body = protocol.experiment.body;
  const sim::Parameters noise_free = family.without_noise(parameters);
  SelfTest test = simulate_test(simulator, noise_free);
  const bool is_other_step = steps_per_second != sim::steps_per_second;
  const sim::Stimulus stimulus =
      is_other_step ? stimulus_at(simulator.stimulus(), steps_per_second) : simulator.stimulus();
  const Balanced balanced = balance(family, family.coefficients(noise_free), body, stimulus, steps_per_second);
  if (balanced.sway.size() < stimulus.rate_rad_s.size())
    refuse_fall(static_cast<double>(balanced.sway.size()) * stimulus.interval_steps / steps_per_second);
  if (is_other_step) test = balance_test(stimulus, balanced, steps_per_second);

  const Loop loop{body, family, family.coefficients(parameters), family.has_unit_gains(), steps_per_second};
  sim::Coefficients sampled = loop.of;
  sampled[sim::Coefficient::delay] += loop.step_s();
  const ControllerLimits limits{.margins = frf::stability_margins(body, family, sampled),
                                .peak_tilt_rad = peak(stimulus.tilt_rad),
                                .peak_sway_rad = peak(balanced.sway),
                                .peak_active_torque_nm = balanced.peak_active_torque_nm};
  const std::string header = header_text(loop, limits, test, origin);
  const std::string source =
      "/* " + origin + source_comment + "#include \"" + name + ".h\"\n\n" + source_text(loop, limits.margins, test);
  return {{with_name(header, name), with_name(source, name)}, limits};
}

}  // namespace decid::tools
