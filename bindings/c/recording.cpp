// Recordings in C.
#include <cmath>
#include <cstddef>
#include <limits>

#include "bindings/c/handles.hpp"
#include "recording/table/columns.hpp"

using namespace decid::c;

decid_recording::decid_recording(decid::recording::Recording of)
    : recording(std::move(of)), warnings(to_c(recording.warnings)) {}

namespace {

using decid::recording::Unit;

std::optional<Unit> unit_of(int unit, const char* where) {
  switch (unit) {
    case DECID_BY_NAME:
      return {};
    case DECID_DEGREES:
      return Unit::degree;
    case DECID_RADIANS:
      return Unit::radian;
    case DECID_MILLIRADIANS:
      return Unit::milliradian;
    case DECID_MILLIMETRES:
    case DECID_CENTIMETRES:
    case DECID_METRES:
      return {};
  }
  throw decid::Error(decid::Code::setting_unknown, where, decid::format("there is no unit %d", unit),
                     "give a value of decid_unit");
}

/// Returns the unit of a tilt, which is an angle. Throws Error for a unit of positions.
std::optional<Unit> tilt_unit_of(int unit, const char* where) {
  const std::optional<Unit> angle = unit_of(unit, where);
  if (!angle && unit != DECID_BY_NAME)
    throw decid::Error(decid::Code::unit_unknown, where,
                       decid::format("tilt_unit is %d, a unit of positions, and a tilt is an angle", unit),
                       "give DECID_DEGREES, DECID_RADIANS, DECID_MILLIRADIANS or DECID_BY_NAME");
  return angle;
}

double fill_gaps_of(double gap_s, const char* where) {
  if (!(gap_s >= 0.0 && gap_s <= decid::recording::longest_gap_s))
    throw decid::Error(decid::Code::setting_out_of_range, where, decid::format("fill_gaps_s is %g", gap_s),
                       decid::format("give a value from 0 to %g s", decid::recording::longest_gap_s));
  return gap_s;
}

std::optional<double> metres_per(int unit) {
  if (unit == DECID_MILLIMETRES) return 1e-3;
  if (unit == DECID_CENTIMETRES) return 1e-2;
  if (unit == DECID_METRES) return 1.0;
  return {};
}

/// Copies the options that choose a table and a recording of the file. Throws Error if they contradict each other.
void choose_part(const decid_read_options& asked, const char* where, decid::recording::RecordingOptions& how) {
  if (asked.skip_lines != -1) how.skip_lines = asked.skip_lines;
  how.section = text_or_empty(asked.section);
  if (how.skip_lines && !how.section.empty())
    throw decid::Error(decid::Code::setting_conflict, where, "section and skip_lines both say where the table begins",
                       "give one of the two");
  const std::string by = text_or_empty(asked.trial_column);
  how.is_one_trial = by == "none";
  if (!how.is_one_trial) how.trial_column = by;
  how.trial = text_or_empty(asked.trial);
  if (how.trial_column.empty() && !how.trial.empty())
    throw decid::Error(decid::Code::setting_missing, where, "trial is given without its column",
                       "give trial_column, which tells recordings apart, or neither");
}

decid::recording::RecordingOptions reading(const decid_read_options& asked, const char* where) {
  decid::recording::RecordingOptions how;
  how.column = text_or_empty(asked.column);
  how.unit = unit_of(asked.unit, where);
  if (asked.rate_hz != 0.0) how.rate_hz = asked.rate_hz;
  how.fill_gaps_s = fill_gaps_of(asked.fill_gaps_s, where);
  if (asked.missing_value != nullptr) how.missing_value = *asked.missing_value;
  const std::string tilt = text_or_empty(asked.tilt_column);
  how.find_tilt = tilt != "none";
  if (how.find_tilt) how.tilt_column = tilt;
  how.tilt_unit = tilt_unit_of(asked.tilt_unit, where);
  how.invert_sway = asked.invert_sway != 0;
  how.invert_tilt = asked.invert_tilt != 0;
  how.metres_per_unit = metres_per(asked.unit);
  if (asked.com_height_m != 0.0) how.com_height_m = asked.com_height_m;
  if (asked.body_height_m != 0.0) how.body_height_m = asked.body_height_m;
  how.leg_column = text_or_empty(asked.leg_column);
  how.trunk_column = text_or_empty(asked.trunk_column);
  how.hip_column = text_or_empty(asked.hip_column);
  how.shoulder_column = text_or_empty(asked.shoulder_column);
  how.ankle_column = text_or_empty(asked.ankle_column);
  how.mean_is_upright = asked.mean_is_upright != 0;
  choose_part(asked, where, how);
  return how;
}

/// Returns the unit of a sway in memory. Throws Error unless it is an angle's.
Unit sway_unit_of(int unit, const char* where) {
  if (const std::optional<Unit> known = unit_of(unit, where)) return *known;
  throw decid::Error(decid::Code::unit_unknown, where, "samples are angles, and have no name that says their unit",
                     "give DECID_DEGREES, DECID_RADIANS or DECID_MILLIRADIANS");
}

std::vector<double> to_rad(const double* values, std::size_t samples, Unit unit) {
  std::vector<double> rad(values, values + samples);
  const double factor = decid::recording::rad_in(unit);
  for (double& value : rad) value *= factor;
  return rad;
}

void invert(std::vector<double>& values) {
  for (double& value : values) value = -value;
}

/// Returns the platform's tilt. Throws Error for a sample that is not finite, and for a unit of positions.
std::vector<double> tilt_of(const decid_samples_options& asked, std::size_t samples, const char* where) {
  const Unit unit = tilt_unit_of(asked.tilt_unit, where).value_or(sway_unit_of(asked.unit, where));
  std::vector<double> tilt_rad = to_rad(asked.tilt, samples, unit);
  for (std::size_t k = 0; k < samples; ++k)
    if (!std::isfinite(tilt_rad[k]))
      throw decid::Error(decid::Code::value_invalid, "recording",
                         decid::format("sample %zu (counted from 1) of the tilt is not finite", k + 1),
                         "interpolate missing samples");
  if (asked.invert_tilt != 0) invert(tilt_rad);
  return tilt_rad;
}

std::unique_ptr<decid_recording> recording_of(const double* sway, std::size_t samples, double rate_hz,
                                              const decid_samples_options& asked, const char* where) {
  using namespace decid::recording;
  const Unit unit = sway_unit_of(asked.unit, where);
  constexpr std::size_t max_samples = std::numeric_limits<std::ptrdiff_t>::max() / sizeof(double);  // of an array
  if (samples > max_samples)
    throw decid::Error(decid::Code::setting_out_of_range, where, decid::format("has %zu samples", samples),
                       decid::format("give the number of values in sway, at most %zu", max_samples));
  if (asked.tilt == nullptr && (asked.tilt_unit != DECID_BY_NAME || asked.invert_tilt != 0))
    throw decid::Error(decid::Code::setting_missing, where, "tilt_unit or invert_tilt is given without a tilt",
                       "give the tilt, or neither");
  Recording made =
      make_recording(to_rad(&given(sway, where, "sway"), samples, unit), rate_hz, asked.mean_is_upright != 0);
  if (asked.invert_sway != 0) invert(made.signals.at(com_sway).rad);
  if (asked.tilt != nullptr) made.signals.add({platform_tilt, "tilt", tilt_of(asked, samples, where)});
  return std::make_unique<decid_recording>(std::move(made));
}

[[noreturn]] void refuse_unnamed(const std::vector<std::string>& trials, const std::string& file) {
  constexpr std::size_t shown = 8;
  std::string names;
  for (std::size_t i = 0; i < std::min(trials.size(), shown); ++i) names += (i == 0 ? "'" : ", '") + trials[i] + "'";
  if (trials.size() > shown) names += ", ...";
  throw decid::Error(decid::Code::recording_ambiguous, file,
                     "holds " + decid::counted(std::ssize(trials), "recording") + ": " + names,
                     "name one of them as trial");
}

}  // namespace

void decid_read_defaults(decid_read_options* options, size_t size) {
  decid_read_options defaults{};
  defaults.skip_lines = -1;
  set_defaults(options, size, defaults);
}

decid_status decid_recording_read(const char* path, const decid_read_options* options, decid_recording** recording) {
  constexpr const char* where = "decid_recording_read";
  return made(recording, where, [&] {
    const std::string file = &given(path, where, "path");
    const decid::recording::RecordingOptions how = reading(options_of(options, decid_read_defaults, where), where);
    if (!how.trial_column.empty() && how.trial.empty()) refuse_unnamed(decid::recording::list_trials(file, how), file);
    return std::make_unique<decid_recording>(decid::recording::read_recording(file, how));
  });
}

decid_status decid_trials_read(const char* path, const decid_read_options* options, decid_trials** trials) {
  constexpr const char* where = "decid_trials_read";
  return made(trials, where, [&] {
    const std::string file = &given(path, where, "path");
    const decid::recording::RecordingOptions how = reading(options_of(options, decid_read_defaults, where), where);
    if (how.trial_column.empty())
      throw decid::Error(decid::Code::setting_missing, where, "no column tells recordings apart",
                         "give its name as trial_column");
    return std::make_unique<decid_trials>(decid_trials{decid::recording::list_trials(file, how)});
  });
}
void decid_trials_free(decid_trials* trials) {
  delete trials;
}
size_t decid_trials_count(const decid_trials* trials) {
  return trials == nullptr ? 0 : trials->names.size();
}
const char* decid_trials_name(const decid_trials* trials, size_t index) {
  return trials == nullptr || index >= trials->names.size() ? nullptr : trials->names[index].c_str();
}

decid_status decid_recording_of(const double* sway, size_t samples, double rate_hz, int unit,
                                decid_recording** recording) {
  constexpr const char* where = "decid_recording_of";
  return made(recording, where, [&] {
    decid_samples_options options;
    decid_samples_defaults(&options, sizeof options);
    options.unit = unit;
    return recording_of(sway, samples, rate_hz, options, where);
  });
}

void decid_samples_defaults(decid_samples_options* options, size_t size) {
  set_defaults(options, size, decid_samples_options{});
}

decid_status decid_recording_of_samples(const double* sway, size_t samples, double rate_hz,
                                        const decid_samples_options* options, decid_recording** recording) {
  constexpr const char* where = "decid_recording_of_samples";
  return made(recording, where, [&] {
    return recording_of(sway, samples, rate_hz, options_of(options, decid_samples_defaults, where), where);
  });
}

void decid_recording_free(decid_recording* recording) {
  delete recording;
}
size_t decid_recording_samples(const decid_recording* recording) {
  return recording == nullptr ? 0 : recording->recording.signals.samples();
}
double decid_recording_rate_hz(const decid_recording* recording) {
  return recording == nullptr ? 0.0 : recording->recording.rate_hz;
}

namespace {

const double* signal_of(const decid_recording* recording, const char* name) {
  if (recording == nullptr) return nullptr;
  const auto* signal = recording->recording.signals.find(name);
  return signal == nullptr ? nullptr : signal->rad.data();
}

}  // namespace

const double* decid_recording_sway(const decid_recording* recording) {
  return signal_of(recording, decid::recording::com_sway);
}
const double* decid_recording_tilt(const decid_recording* recording) {
  return signal_of(recording, decid::recording::platform_tilt);
}
const char* decid_recording_column(const decid_recording* recording) {
  if (recording == nullptr) return nullptr;
  if (recording->recording.file.empty()) return "";
  return recording->recording.signals.find(decid::recording::com_sway)->column.c_str();
}
size_t decid_recording_warnings(const decid_recording* recording) {
  return recording == nullptr ? 0 : recording->warnings.size();
}
const decid_warning* decid_recording_warning(const decid_recording* recording, size_t index) {
  return recording == nullptr ? nullptr : at(recording->warnings, index);
}
