// Axes of one centre of mass: the one that follows the tilt is the sway, and turned axes are named.
#include "recording/detail/sway/sway_axis.hpp"

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "base/math/random.hpp"
#include "base/text.hpp"
#include "recording/quality/detail/response_check.hpp"
#include "sim/simulate.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"
#include "tests/recording/default_protocol.hpp"
#include "tests/recording/table/reading.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

/// Returns a trial i of the middle of the prior, in rad.
std::vector<double> forward(std::uint64_t i) {
  const sim::Parameters parameters = simulator().protocol().parameters().middle();
  std::vector<double> values(static_cast<std::size_t>(simulator().samples()));
  for (std::uint64_t attempt = 0;; ++attempt)
    if (simulator().run(parameters, Random(7, sim::streams::vestibular_noise, 1000 * i + attempt), values).valid)
      return values;
}

/// Returns a slow sway of 0.3 degrees without a response to the tilt, in rad.
std::vector<double> lateral(std::size_t samples) {
  const Random random(8, sim::streams::sensor_noise, 0);
  std::vector<double> values(samples);
  double slow = 0.0;
  for (std::size_t k = 0; k < samples; ++k) {
    slow = 0.995 * slow + 0.1 * random.normal(k);
    values[k] = 0.3 * sim::rad_per_deg * slow;
  }
  return values;
}

/// A table of the time and these columns.
std::string table(const std::string& header, const std::vector<std::vector<double>>& columns) {
  std::string text = header + "\n";
  char cell[40];
  for (std::size_t k = 0; k < columns.front().size(); ++k) {
    std::snprintf(cell, sizeof cell, "%.2f", 0.01 * static_cast<double>(k));
    text += cell;
    for (const std::vector<double>& column : columns) {
      std::snprintf(cell, sizeof cell, ",%.4f", column[k]);
      text += cell;
    }
    text += '\n';
  }
  return text;
}

/// Returns 950 mm times a x + b y, with 0.2 mm of noise.
std::vector<double> millimetres(const std::vector<double>& x, double a, const std::vector<double>& y, double b) {
  const Random random(9, sim::streams::sensor_noise, 0);
  std::vector<double> values(x.size());
  for (std::size_t k = 0; k < x.size(); ++k) values[k] = 950.0 * (a * x[k] + b * y[k]) + 0.2 * random.normal(k);
  return values;
}

struct Brought {
  Recording recording;
  std::string column;
};

Brought brought(const std::string& text, const RecordingOptions& options = {.com_height_m = 0.95},
                const ProtocolPlan& of = plan()) {
  Brought result{read(text, options), {}};
  result.column = bring_to_protocol(result.recording, of).signals.at(com_sway).column;
  return result;
}

}  // namespace

TEST_CASE("of several axes of a centre of mass, the sway is the one that follows the tilt") {
  const std::vector<double> ap = forward(1), ml = lateral(ap.size()), up(ap.size(), 950.0);
  const std::vector<double> along = millimetres(ap, 1.0, ml, 0.0), across = millimetres(ap, 0.0, ml, 1.0);
  const std::string header = "time,COM_x_mm,COM_y_mm,COM_z_mm";
  for (const auto& [text, axis] : {std::pair{table(header, {across, along, up}), "COM_y_mm"},
                                   {table(header, {along, across, up}), "COM_x_mm"},
                                   {table(header, {across, up, along}), "COM_z_mm"}}) {
    const Brought found = brought(text);
    CHECK(found.column == axis);
    const Warning* chosen = warning(found.recording.warnings, "axis_chosen");
    REQUIRE(chosen != nullptr);
    CHECK(chosen->severity == Severity::info);
    CHECK(contains(chosen->text, "decid uses '" + std::string(axis) + "'"));
    CHECK_FALSE(has(found.recording.warnings, "axes_turned"));
    CHECK(found.recording.other_axes.empty());
  }
  // A named axis is used.
  const Brought named = brought(table(header, {across, along, up}), {.column = "COM_x_mm", .com_height_m = 0.95});
  CHECK(named.column == "COM_x_mm");
  CHECK_FALSE(has(named.recording.warnings, "axis_chosen"));
  // Angles too, and one axis needs no choice.
  std::vector<double> deg = ap, other = ml;
  for (double& value : deg) value /= sim::rad_per_deg;
  for (double& value : other) value /= sim::rad_per_deg;
  CHECK(brought(table("time,COM_x_deg,COM_y_deg", {other, deg}), {}).column == "COM_y_deg");
  CHECK_FALSE(has(brought(table("time,COM_x_deg", {deg}), {}).recording.warnings, "axis_chosen"));
}

TEST_CASE("of axes of which none follows the tilt, the first is assumed, which a caution says") {
  const std::vector<double> ap = forward(1), ml = lateral(ap.size());
  std::vector<double> reversed(ml.rbegin(), ml.rend());
  const Brought found =
      brought(table("time,COM_x_mm,COM_y_mm", {millimetres(ml, 1.0, ml, 0.0), millimetres(reversed, 1.0, ml, 0.0)}));
  CHECK(found.column == "COM_x_mm");
  CHECK_FALSE(has(found.recording.warnings, "axis_chosen"));
  const Warning* assumed = warning(found.recording.warnings, "axis_assumed");
  REQUIRE(assumed != nullptr);
  CHECK(assumed->severity == Severity::caution);
  CHECK(contains(assumed->text, "'COM_x_mm', 'COM_y_mm' are axes"));
}

TEST_CASE("recordings of axes that start late, and of short trials, are read") {
  for (const std::size_t late : {50U, 80U}) {
    CAPTURE(late);
    for (const std::uint64_t i : {1U, 2U}) {
      std::vector<double> ap = forward(i);
      ap.erase(ap.begin(), ap.begin() + static_cast<std::ptrdiff_t>(late));
      const std::vector<double> ml = lateral(ap.size());
      const std::string text =
          table("time,COM_x_mm,COM_y_mm", {millimetres(ap, 0.0, ml, 1.0), millimetres(ap, 1.0, ml, 0.0)});
      CHECK(brought(text).column == "COM_y_mm");
    }
  }
  // One cycle of 60.5 s is enough, 20 s are not.
  const auto read_late = [](const sim::Protocol& protocol) {
    const auto samples = static_cast<std::size_t>(protocol.samples());
    std::vector<double> ap = forward(1);
    ap.erase(ap.begin(), ap.begin() + 50);
    ap.resize(samples);
    const std::vector<double> ml = lateral(samples);
    return brought(table("time,COM_x_mm,COM_y_mm", {millimetres(ap, 0.0, ml, 1.0), millimetres(ap, 1.0, ml, 0.0)}),
                   {.com_height_m = 0.95}, ProtocolPlan(protocol));
  };
  sim::Protocol protocol = sim::default_protocol();
  protocol.sequence().cycles = 1;
  CHECK(read_late(protocol).column == "COM_y_mm");
  protocol.sequence().feedback = {0, 0, -1, 1};
  protocol.sequence().start = {0, 0, 0, 1};
  REQUIRE(protocol.samples() < 4000);
  const Brought found = read_late(protocol);
  CHECK(found.column == "COM_x_mm");
  CHECK(has(found.recording.warnings, "axis_assumed"));
}

TEST_CASE("an axis that cannot be read is named, with a caution if no other one follows the tilt") {
  const std::vector<double> ap = forward(1), ml = lateral(ap.size());
  const std::string header = "time,COM_x_mm,COM_y_mm";
  const std::vector<double> along = millimetres(ap, 1.0, ml, 0.0), across = millimetres(ap, 0.0, ml, 1.0);
  for (const char* cell : {"", "x"}) {
    CAPTURE(std::string(cell));
    const auto with_fault = [&](std::string text) {
      const std::size_t end = text.find('\n', 60'000), begin = text.rfind(',', end) + 1;
      return text.replace(begin, end - begin, cell);
    };
    const Brought lost = brought(with_fault(table(header, {across, along})));
    CHECK(lost.column == "COM_x_mm");
    const Warning* assumed = warning(lost.recording.warnings, "axis_assumed");
    REQUIRE(assumed != nullptr);
    CHECK(contains(assumed->text, "'COM_y_mm' cannot be read: "));
    const Brought found = brought(with_fault(table(header, {along, across})));
    CHECK(found.column == "COM_x_mm");
    CHECK_FALSE(has(found.recording.warnings, "axis_assumed"));
    const Warning* chosen = warning(found.recording.warnings, "axis_chosen");
    REQUIRE(chosen != nullptr);
    CHECK(contains(chosen->text, "'COM_y_mm' cannot be read: "));
  }
  const std::vector<double> up(ap.size(), 950.0);
  CHECK_FALSE(has(brought(table(header, {across, up})).recording.warnings, "axis_assumed"));
}

TEST_CASE("an axis with rows of its own is not read, and is named") {
  const std::vector<double> ap = forward(1), ml = lateral(ap.size());
  const std::vector<double> along = millimetres(ap, 1.0, ml, 0.0), across = millimetres(ap, 0.0, ml, 1.0);
  std::string text = "time,COM_x_mm,COM_y_mm\n";
  for (std::size_t k = 0; k < ap.size(); ++k)
    text += format("%.3f,%.4f,\n%.3f,,%.4f\n", 0.01 * static_cast<double>(k), across[k],
                   0.01 * static_cast<double>(k) + 0.003, along[k]);
  const Brought found = brought(text);
  CHECK(found.column == "COM_x_mm");
  const Warning* assumed = warning(found.recording.warnings, "axis_assumed");
  REQUIRE(assumed != nullptr);
  CHECK(contains(assumed->text, "'COM_y_mm' has rows of its own"));
  CHECK(brought(text, {.column = "COM_y_mm", .com_height_m = 0.95}).column == "COM_y_mm");
}

TEST_CASE("axes that are turned against the tilt both follow it, which a caution says") {
  const std::vector<double> ap = forward(2), ml = lateral(ap.size());
  const auto turned = [&](double degrees) {
    const double c = std::cos(degrees * sim::rad_per_deg), s = std::sin(degrees * sim::rad_per_deg);
    return brought(
        table("time,COM_x_mm,COM_y_mm", {millimetres(ap, c, ml, -0.1 * s), millimetres(ap, s, ml, 0.1 * c)}));
  };
  for (const double degrees : {30.0, 60.0}) {
    CAPTURE(degrees);
    const Brought found = turned(degrees);
    CHECK(found.column == (degrees < 45.0 ? "COM_x_mm" : "COM_y_mm"));
    const Warning* caution = warning(found.recording.warnings, "axes_turned");
    REQUIRE(caution != nullptr);
    CHECK(caution->severity == Severity::caution);
    CHECK(contains(caution->text, degrees < 45.0 ? "'COM_y_mm' follows" : "'COM_x_mm' follows"));
  }
  CHECK_FALSE(has(turned(5.0).recording.warnings, "axes_turned"));
}

TEST_CASE("the response of signals: large for a sway, none for other signals, zero for a constant and a short trial") {
  const std::vector<double> ap = forward(3);
  const ResponseCheck& check = plan().response();
  const ResponseCheck::Response sway = check.response_of(ap), other = check.response_of(lateral(ap.size()));
  CHECK(sway.gain > 60.0);
  CHECK(sway.rms_rad > 0.05 * sim::rad_per_deg);
  CHECK(other.gain < 40.0);
  CHECK(check.response_of(std::vector<double>(ap.size(), 0.1)).gain == 0.0);
  CHECK(ResponseCheck(std::vector<double>(3000, 0.1), 100.0).response_of(std::vector<double>(3000, 0.1)).gain == 0.0);
}
