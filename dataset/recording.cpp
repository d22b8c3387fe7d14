// Recordings: which column is the sway, in which unit, at which rate; and whether it fits a model's protocol.
// The rules for finding them are ours, made for EUROBENCH files (time,COM_x), exports of motion capture and decid's
// own.
#include "dataset/recording.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/file.hpp"
#include "dataset/columns.hpp"
#include "dataset/csv.hpp"

namespace decid::dataset {

namespace {

constexpr std::size_t file_limit_bytes = std::size_t{1} << 30;
constexpr double slowest_plausible_hz = 5.0;
constexpr double largest_plausible_deg = 20.0, smallest_plausible_deg = 0.001, largest_deg = 90.0;
/// Where degrees are only assumed, a sway below this is more likely in radians: quiet stance alone sways more.
constexpr double small_for_a_guess_deg = 0.1;
/// So much of a recording may hang over the end of the protocol.
constexpr double cut_limit_s = 1.0;

int find_sway(const CsvTable& table, int time, Recording& recording) {
  for (const char* name :
       {"com_sway", "com_x", "sway", "body_sway", "com_ap", "sway_ap", "com_angle", "sway_angle", "a_bs", "com"}) {
    for (int i = 0; i < table.columns(); ++i) {
      if (i != time && name_without_unit(table.names()[static_cast<std::size_t>(i)]) == name) return i;
    }
  }
  const int candidates = table.columns() - (time >= 0 ? 1 : 0);
  if (candidates == 0) {
    throw Error(recording.file, "has a column of time but none of sway", "add the sway, or name it with --column");
  }
  if (candidates > 1) {
    throw Error(recording.file, "has several columns that may be the sway: " + list_of(table, time),
                "name one with --column");
  }
  const int sway = time == 0 ? 1 : 0;
  if (table.has_header()) {
    recording.warnings.push_back("column '" + table.names()[static_cast<std::size_t>(sway)] +
                                 "' is taken as the sway: it is the only one");
  }
  return sway;
}

double find_rate(const CsvTable& table, int time, const RecordingOptions& options, Recording& recording) {
  if (options.rate_hz && !(std::isfinite(*options.rate_hz) && *options.rate_hz > 0.0)) {
    throw Error(recording.file, "the rate " + six_digits(*options.rate_hz) + " Hz is not positive",
                "give the samples per second as --rate");
  }
  if (time < 0) {
    if (options.rate_hz) return *options.rate_hz;
    throw Error(recording.file, "has no column of time", "give the sample rate in Hz as --rate");
  }
  const std::string name = "'" + table.names()[static_cast<std::size_t>(time)] + "'";
  double rate = 0.0;
  try {
    rate = rate_of(table, time, recording.file, "--rate");
  } catch (const Error& error) {
    if (!options.rate_hz) throw;
    recording.warnings.push_back("the column of time is not used: " + error.problem());
    return *options.rate_hz;
  }
  if (options.rate_hz) {
    if (std::abs(rate - *options.rate_hz) > rate_tolerance * rate) {
      recording.warnings.push_back("the column " + name + " says " + six_digits(rate) + " Hz, the rate given is " +
                                   six_digits(*options.rate_hz) + " Hz; the rate given is used");
    }
    return *options.rate_hz;
  }
  if (rate < slowest_plausible_hz) {
    recording.warnings.push_back("the column " + name + " says " + six_digits(rate) +
                                 " Hz, which is slow; if it is not in seconds, call it time_ms or give --rate");
  }
  return rate;
}

/// Brings the sway to radians and holds its size against what a standing body does.
void convert(Recording& recording, const RecordingOptions& options) {
  const std::optional<Unit> unit = options.unit ? options.unit : unit_in(recording.column);
  const std::string last_word = words(recording.column).back();
  if (!unit && words(recording.column).size() > 1 && one_of(last_word, {"mm", "cm", "m", "meter", "metre"})) {
    throw Error(recording.file, recording.column + " is a length by its name, not an angle",
                "divide it by the height of the centre of mass above the ankles, or give --unit if it is an angle");
  }
  if (!unit) recording.warnings.push_back("no unit in the name of " + recording.column + ": degrees are assumed");
  if (unit.value_or(Unit::degree) == Unit::degree) {
    for (double& value : recording.sway_rad) value *= sim::rad_per_deg;
  }
  const auto [least, most] = std::minmax_element(recording.sway_rad.begin(), recording.sway_rad.end());
  const double peak_deg = std::max(-*least, *most) / sim::rad_per_deg;
  const double peak_to_peak_deg = (*most - *least) / sim::rad_per_deg;
  const char* other = "if the unit is another, give --unit";
  if (*least == *most) {
    throw Error(recording.file, recording.column + " is constant, " + six_digits(*most / sim::rad_per_deg) + " degrees",
                "name the column of sway with --column");
  }
  if (peak_deg > largest_deg) {
    throw Error(recording.file, recording.column + " reaches " + six_digits(peak_deg) + " degrees, beyond lying flat",
                other);
  }
  if (peak_deg > largest_plausible_deg) {
    recording.warnings.push_back("sway reaches " + six_digits(peak_deg) + " degrees, more than a standing body does; " +
                                 other);
  }
  if (peak_to_peak_deg < smallest_plausible_deg || (!unit && peak_to_peak_deg < small_for_a_guess_deg)) {
    recording.warnings.push_back("sway is only " + six_digits(peak_to_peak_deg) + " degrees peak to peak, " +
                                 six_digits(peak_to_peak_deg / sim::rad_per_deg) + " if these are radians; " + other);
  }
}

std::string count_at(std::size_t samples, double rate_hz) {
  return std::to_string(samples) + " samples at " + six_digits(rate_hz) + " Hz (" +
         six_digits(static_cast<double>(samples) / rate_hz) + " s)";
}

}  // namespace

Recording read_recording(const std::filesystem::path& path, const RecordingOptions& options) {
  Recording recording;
  recording.file = path.string();
  const CsvTable table(read_file(path, file_limit_bytes), recording.file);
  if (table.rows() < 2) throw Error(recording.file, "has only one sample", "name a whole recording");
  int time = find_time(table);
  const int sway = options.column.empty() ? find_sway(table, time, recording)
                                          : named_column(table, options.column, recording.file, "--column");
  if (sway == time) time = -1;  // the user knows better than its looks
  recording.column = table.names()[static_cast<std::size_t>(sway)];
  recording.rate_hz = find_rate(table, time, options, recording);
  recording.sway_rad = table.numbers(sway);
  convert(recording, options);
  return recording;
}

std::vector<float> fit_to_protocol(Recording& recording, const sim::Protocol& protocol) {
  const double rate = protocol.sample_rate_hz;
  const auto needed = static_cast<std::size_t>(protocol.samples());
  const std::size_t recorded = recording.sway_rad.size();
  const bool same_rate = std::abs(recording.rate_hz - rate) <= rate_tolerance * rate;
  // The length is settled before any work is done.
  const double available = static_cast<double>(recorded) * (same_rate ? 1.0 : rate / recording.rate_hz);
  const double excess = available - static_cast<double>(needed);
  constexpr double rounding = 1e-6;
  if (!(excess >= -rounding && excess <= cut_limit_s * rate + rounding)) {
    throw Error(recording.file,
                "recording has " + count_at(recorded, recording.rate_hz) + "; the model's protocol '" + protocol.name +
                    "' needs " + count_at(needed, rate),
                "train a model for its protocol: decid dataset --protocol ..., decid train ..., then identify "
                "--model; or give --rate if the time column is wrong");
  }
  std::vector<double> sway = same_rate ? recording.sway_rad : resample(recording.sway_rad, recording.rate_hz, rate);
  if (!same_rate) {
    recording.warnings.push_back("resampled from " + six_digits(recording.rate_hz) + " Hz to " + six_digits(rate) +
                                 " Hz");
  }
  if (sway.size() > needed) {
    recording.warnings.push_back(std::to_string(sway.size() - needed) + " samples beyond the protocol's " +
                                 six_digits(protocol.duration_s()) + " s are cut off");
  }
  std::vector<float> result(needed);
  std::transform(sway.begin(), sway.begin() + static_cast<std::ptrdiff_t>(needed), result.begin(),
                 [](double value) { return static_cast<float>(value); });
  return result;
}

}  // namespace decid::dataset
