// Protocols in files, and the measured tilts that they name: see protocol_file.hpp.
#include "recording/protocol_file.hpp"

#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/setting.hpp"
#include "recording/detail/clock.hpp"
#include "recording/resample.hpp"
#include "recording/table/columns.hpp"
#include "recording/table/table.hpp"
#include "sim/protocol/protocol_json.hpp"

namespace decid::recording {
namespace {

/// The size of a million samples of a measured tilt with blanks; a larger file is not a protocol.
constexpr std::size_t protocol_limit_bytes = std::size_t{1} << 26;
constexpr double max_samples = 1e6;  // of a measured tilt, as in sim::Protocol
/// The allowed relative difference between a given rate and the rate of even times, which may be rounded (60 Hz as
/// steps of 0.0167 s).
constexpr double contradiction = 0.01;
/// The allowed deviation of a cycle from a whole number of samples: each cycle adds it to the lag behind the platform.
constexpr double max_drift = 0.05;

int find_tilt(const Table& table, int time, const std::string& where) {
  int named = find_tilt_column(table, time, where, "measured.column");
  if (named < 0) named = find_named(table, time, {"fs"}, where, "measured.column");
  if (named >= 0) return named;
  const int candidates = table.columns() - (time >= 0 ? 1 : 0);
  if (candidates == 1) return time == 0 ? 1 : 0;
  throw Error(candidates == 0 ? Code::column_missing : Code::column_ambiguous, where,
              candidates == 0 ? "has a time column but no tilt column"
                              : "has several columns that may be the tilt: " + to_list(table, time),
              "name one as measured.column");
}

/// Returns the rate, if the file states it clearly.
std::optional<double> own_rate(const Table& table, int time, const std::string& where) {
  if (time < 0) {
    const std::optional<StatedRate> stated = stated_rate(table, where, "measured.rate_hz");
    return stated ? std::optional(stated->hz) : std::nullopt;
  }
  try {
    const Clock clock = read_clock(table, time, where, "measured.rate_hz");
    if (clock.place.empty()) return clock.rate_hz;
  } catch (const Error&) {  // measured.rate_hz serves files whose times are unusable
  }
  return {};
}

double find_rate(const Table& table, int time, const sim::TiltFileReference& file, const std::string& where) {
  if (file.rate_hz) {
    const double rate = *file.rate_hz;
    if (!is_sample_rate(rate))
      throw Error(Code::setting_out_of_range, where, "measured.rate_hz is " + six_digits(rate), "give 1 to 100,000");
    const std::optional<double> stated = own_rate(table, time, where);
    if (!stated || std::abs(rate - *stated) <= contradiction * *stated) return rate;
    throw Error(Code::setting_conflict, where,
                "measured.rate_hz is " + six_digits(rate) + ", and its times give " + six_digits(*stated) + " Hz",
                "leave measured.rate_hz out, or correct the times");
  }
  if (time >= 0) {
    const Clock clock = read_clock(table, time, where, "measured.rate_hz");
    if (!is_sample_rate(clock.rate_hz))
      throw Error(Code::setting_out_of_range, where,
                  "its times give " + six_digits(clock.rate_hz) + " Hz, not from 1 to 100,000",
                  "if they are in milliseconds, call their column time_ms, or give measured.rate_hz");
    if (clock.place.empty()) return clock.rate_hz;
    throw Error(Code::times_uneven, where, clock.first_uneven,
                "correct the times, or give measured.rate_hz if the samples are evenly spaced");
  }
  if (const std::optional<StatedRate> stated = stated_rate(table, where, "measured.rate_hz")) return stated->hz;
  throw Error(Code::rate_unknown, where, "has no time column", "give its samples per second as measured.rate_hz");
}

/// Returns the tilt in degrees at sample_rate_hz. Resamples a tilt of another rate: a cycle periodically, another tilt
/// with its ends reflected (resample.hpp: Ends). Errors name the settings as a protocol does ("measured.column").
std::vector<double> read_tilt_deg(const std::filesystem::path& path, const sim::TiltFileReference& file,
                                  double sample_rate_hz, Warnings* warnings) {
  const std::string where = path.string();
  const std::unique_ptr<Table> read = read_table(path);
  const Table& table = *read;
  int time = find_time(table);
  const int column =
      file.column.empty() ? find_tilt(table, time, where) : named_column(table, file.column, where, "measured.column");
  if (column == time) time = -1;
  const std::string& name = table.name(column);
  const std::optional<Unit> said =
      file.says_unit ? std::optional(file.in_degrees ? Unit::degree : Unit::radian) : std::nullopt;
  if (const std::optional<Unit> named = unit_in(name); said && named && *said != *named)
    throw Error(Code::setting_conflict, where,
                "the name of " + name + " has another unit than measured.unit, which is \"" +
                    (file.in_degrees ? "deg" : "rad") + "\"",
                "leave measured.unit out, or correct the column's name");
  std::optional<Unit> unit = find_unit(name, said, where, "measured.unit");
  if (!unit) unit = table.unit();
  if (!unit)
    throw Error(Code::unit_unknown, where, "the name of " + name + " has no unit",
                "give measured.unit, \"deg\" or \"rad\"");
  const std::size_t rows = table.rows(column);
  if (rows < 2) throw Error(Code::recording_too_short, where, "has only one sample", "give a whole recording");
  const double rate = find_rate(table, time, file, where);
  const bool same_rate = std::abs(rate - sample_rate_hz) <= rate_tolerance * sample_rate_hz;
  const double samples = static_cast<double>(rows) * (same_rate ? 1.0 : sample_rate_hz / rate);
  if (!(samples >= 2.0 && samples <= max_samples)) {
    throw Error(Code::setting_out_of_range, where,
                "its " + std::to_string(rows) + " samples at " + six_digits(rate) + " Hz make " +
                    six_digits(std::floor(samples)) + " at the protocol's " + six_digits(sample_rate_hz) + " Hz",
                "check the rate; give 2 to 1,000,000 samples");
  }
  std::vector<double> tilt = table.numbers(column);
  if (warnings != nullptr) {
    warnings->insert(warnings->end(), table.warnings().begin(), table.warnings().end());
    if (const std::string change = table.change_at(column); !change.empty()) add_info(*warnings, "resampled", change);
  }
  if (*unit == Unit::milliradian)
    for (double& value : tilt) value *= rad_in(Unit::milliradian);
  if (*unit != Unit::degree)
    for (double& value : tilt) value /= sim::rad_per_deg;
  if (file.is_cycle) {
    // The check precedes resampling, which would spread a jump over its neighbours.
    if (const std::string problem = sim::broken_joint(tilt); !problem.empty()) {
      throw Error(Code::setting_out_of_range, where, problem, "give cycles 1, or a recording of whole cycles");
    }
  }
  if (same_rate) return tilt;
  if (!file.is_cycle) return resample(tilt, rate, sample_rate_hz, Ends::reflected);
  const double whole = std::round(samples);
  if (std::abs(samples - whole) > max_drift) {
    throw Error(Code::setting_out_of_range, where,
                "its " + std::to_string(rows) + " samples at " + six_digits(rate) + " Hz are " + six_digits(samples) +
                    " at the protocol's " + six_digits(sample_rate_hz) + " Hz; whole cycles need a whole number",
                "give cycles 1, or a cycle of whole sample periods, measured at another rate or cut to length");
  }
  return resample_cycle(tilt, static_cast<std::size_t>(whole));
}

}  // namespace

sim::Protocol load_protocol(const std::string& name_or_path, std::vector<std::string>* files, Warnings* warnings,
                            const std::string& controller) {
  const sim::BodyModel& asked =
      controller.empty() ? sim::single_pendulum() : sim::find_body_model(controller, setting("controller"));
  if (name_or_path == "default" || name_or_path == "short") {
    sim::Protocol protocol = name_or_path == "short" ? sim::short_protocol() : sim::default_protocol();
    protocol.experiment.body_model = &asked;
    protocol.names_controller = !controller.empty();
    return protocol;
  }
  std::error_code ignored;
  if (!std::filesystem::exists(name_or_path, ignored)) {
    throw Error(Code::file_missing, name_or_path, "is neither a built-in protocol nor a file",
                "use default, short, or the path of a JSON file");
  }
  if (files) files->push_back(name_or_path);
  const std::filesystem::path path = name_or_path;
  const auto read_tilt = [&](const sim::TiltFileReference& named, double sample_rate_hz) {
    const std::filesystem::path tilt = path.parent_path() / named.file;
    if (files) files->push_back(tilt.string());
    return read_tilt_deg(tilt, named, sample_rate_hz, warnings);
  };
  sim::Protocol protocol = sim::protocol_from_text(
      read_file(name_or_path, protocol_limit_bytes),
      {.where = name_or_path, .name = path.stem().string(), .read_tilt = read_tilt, .controller = &asked});
  const std::string& own = protocol.experiment.body_model->name;
  if (!controller.empty() && own != controller)
    throw Error(Code::setting_conflict, name_or_path,
                "has the controller '" + own + "', and " + setting("controller") + " is '" + controller + "'",
                "give the protocol's controller, or none");
  protocol.names_controller |= !controller.empty();
  return protocol;
}

}  // namespace decid::recording
