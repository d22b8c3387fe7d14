// C3D files: see c3d.hpp. The reader refuses files whose header and parameters disagree on where numbers lie.
#include "recording/formats/detail/c3d.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "base/error.hpp"
#include "recording/resample.hpp"

namespace decid::recording {

namespace {

constexpr char format_key = '\x50';
/// Byte offsets of the header's 16-bit words.
constexpr std::size_t points_at = 2, analog_at = 4, first_frame_at = 6, last_frame_at = 8, scale_at = 12, data_at = 16,
                      samples_at = 18, rate_at = 20;
constexpr std::size_t max_c3d_columns = 10'000;
constexpr std::uint16_t max_short_frames = 65535;  ///< the largest 16-bit count

/// Reads the byte after the parameter section's block count: the processor.
C3dBytes open_file(std::string_view bytes, const std::string& where) {
  if (bytes.size() < c3d_block_bytes || bytes[1] != format_key || bytes[0] == 0)
    throw Error(Code::file_damaged, where, "is not a C3D file, or is damaged",
                "export it again from the motion capture program");
  const C3dBytes raw(bytes, C3dBytes::Processor::intel, where);
  const unsigned processor = raw.byte((raw.byte(0) - 1U) * c3d_block_bytes + 3);
  if (processor < 84 || processor > 86)
    refuse_damaged_c3d(where, "its parameters have the processor code " + std::to_string(processor) +
                                  ", not 84 (Intel), 85 (DEC) or 86 (MIPS)");
  return {bytes, static_cast<C3dBytes::Processor>(processor), where};
}

/// Returns a count of the parameters. Throws Error unless it equals the header's.
std::size_t agreed(const C3dParameters& parameters, const std::string& name, std::size_t in_header,
                   const std::string& where) {
  const double count = parameters.count(name, static_cast<double>(in_header));
  if (count != static_cast<double>(in_header))
    refuse_damaged_c3d(where, name + " differs from the header's " + std::to_string(in_header));
  return in_header;
}

/// Returns a 32-bit frame number from its two words.
std::optional<double> frame_number(const C3dParameters& parameters, const std::string& name) {
  const std::vector<double> words = parameters.numbers(name);
  double number = 0.0, unit = 1.0;
  for (std::size_t k = 0; k < words.size() && k < 2; ++k, unit = 65536.0) {
    if (!(words[k] >= -32768.0 && words[k] <= 65535.0)) return {};
    number += unit * (words[k] < 0.0 ? words[k] + 65536.0 : words[k]);
  }
  return words.empty() ? std::nullopt : std::optional(number);
}

std::string column_name(const std::string& name, const std::string& unit) {
  return unit.empty() ? name : name + " (" + unit + ")";
}

/// Removes the subject's name from labels, if they name at most one subject.
void remove_subject(std::vector<std::string>& labels) {
  std::optional<std::string> subject;
  for (const std::string& label : labels) {
    const std::size_t colon = label.find(':');
    if (colon == std::string::npos) continue;
    if (subject && *subject != label.substr(0, colon)) return;
    subject = label.substr(0, colon);
  }
  if (!subject) return;
  for (std::string& label : labels)
    if (label.starts_with(*subject + ":")) label.erase(0, subject->size() + 1);
}

/// Returns the units of points that are not positions (angles, forces, ...) by their labels, with and without the
/// subject's name.
std::map<std::string, std::string> units_of_kinds(const C3dParameters& parameters) {
  std::map<std::string, std::string> units;
  for (const auto& [kind, unit] : {std::pair{"ANGLES", "ANGLE_UNITS"},
                                   {"FORCES", "FORCE_UNITS"},
                                   {"MOMENTS", "MOMENT_UNITS"},
                                   {"POWERS", "POWER_UNITS"},
                                   {"SCALARS", "SCALAR_UNITS"}}) {
    const std::string text = parameters.text(std::string("POINT:") + unit);
    std::vector<std::string> labels = parameters.texts(std::string("POINT:") + kind);
    for (const std::string& label : labels) units.emplace(label, text);
    remove_subject(labels);
    for (const std::string& label : labels) units.emplace(label, text);
  }
  return units;
}

}  // namespace

bool is_c3d(std::string_view bytes, std::string_view end) {
  // The first byte gives the block of the parameters; text starts with a digit or a letter.
  return end == ".c3d" || (bytes.size() >= c3d_block_bytes && bytes[1] == format_key && bytes[0] >= 1 && bytes[0] <= 8);
}

C3dTable::C3dTable(std::string bytes, std::string where)
    : bytes_(std::move(bytes)), where_(std::move(where)), file_(open_file(bytes_, where_)) {
  const std::size_t section = (file_.byte(0) - 1U) * c3d_block_bytes, block = file_.word(data_at);
  if (block == 0) refuse_damaged_c3d(where_, "its header has no block number of the data");
  data_ = (block - 1) * c3d_block_bytes;
  const C3dParameters parameters(data_ > section ? file_.first(std::min(data_, file_.size())) : file_, section);
  read_layout(parameters);
  name_points(parameters);
  name_channels(parameters);
  read_rates(parameters);
}

void C3dTable::read_layout(const C3dParameters& parameters) {
  agreed(parameters, "POINT:DATA_START", data_ / c3d_block_bytes + 1, where_);
  points_ = agreed(parameters, "POINT:USED", file_.word(points_at), where_);
  const std::size_t analog = file_.word(analog_at), samples = file_.word(samples_at);
  if (analog > 0) {
    samples_ = std::max<std::size_t>(samples, 1);
    channels_ = analog / samples_;
    if (channels_ * samples_ != analog)
      refuse_damaged_c3d(where_, std::to_string(analog) + " analog values per frame are not a multiple of " +
                                     std::to_string(samples_) + " samples per channel");
    agreed(parameters, "ANALOG:USED", channels_, where_);
  }
  if (points_ + channels_ == 0)
    throw Error(Code::file_empty, where_, "is a C3D file without points and analog channels",
                "give a file that holds the trial");
  if (3 * points_ + channels_ > max_c3d_columns)
    throw Error(Code::file_too_large, where_, "has " + std::to_string(3 * points_ + channels_) + " columns",
                "give a file of at most 10,000");
  scale_ = parameters.number("POINT:SCALE", file_.real(scale_at));
  is_real_ = scale_ < 0.0;
  if (!is_real_ && points_ > 0 && !(scale_ > 0.0 && std::isfinite(scale_)))
    refuse_damaged_c3d(where_, "POINT:SCALE is not a scale for its integers");
  if (is_real_ != (file_.real(scale_at) < 0.0))
    refuse_damaged_c3d(where_, "POINT:SCALE and the header disagree on whether its data are integers or reals");
  is_unsigned_ = parameters.text("ANALOG:FORMAT") == "UNSIGNED";
  const std::size_t section = (file_.byte(0) - 1U) * c3d_block_bytes, end = section > data_ ? section : file_.size();
  const std::size_t there = end - std::min(data_, end);
  frames_ = count_frames(parameters, there);
  if (frames_ > there / frame_bytes())
    refuse_damaged_c3d(where_, "it should have " + std::to_string(frames_) + " frames and has " +
                                   std::to_string(there / frame_bytes()));
  look_for_more_frames(there);
  rows_ = points_ > 0 ? frames_ : frames_ * samples_;
  if (rows_ > max_rows)
    throw Error(Code::file_too_large, where_, "has more than 10 million rows", "cut it to one trial");
}

std::size_t C3dTable::count_frames(const C3dParameters& parameters, std::size_t data_bytes) const {
  const double first = file_.word(first_frame_at), last = file_.word(last_frame_at);
  const double stated = parameters.count("POINT:FRAMES", last - first + 1.0);
  std::vector<double> counts;
  const auto add = [&](double count) {
    if (std::ranges::find(counts, count) == counts.end()) counts.push_back(count);
  };
  const auto begin = frame_number(parameters, "TRIAL:ACTUAL_START_FIELD"),
             end = frame_number(parameters, "TRIAL:ACTUAL_END_FIELD");
  if (begin && end) add(*end - *begin + 1.0);
  if (parameters.find("POINT:LONG_FRAMES") != nullptr) add(parameters.number("POINT:LONG_FRAMES", 0.0));
  if (stated != double{max_short_frames} || counts.empty()) add(stated);
  // If the counts differ, keep the count whose frames end in the last block of the file.
  if (counts.size() > 1)
    std::erase_if(counts, [&](double count) {
      const double used = count * static_cast<double>(frame_bytes());
      return !(used <= static_cast<double>(data_bytes) &&
               used + static_cast<double>(c3d_block_bytes) > static_cast<double>(data_bytes));
    });
  if (counts.size() != 1) refuse_damaged_c3d(where_, "its frame counts contradict each other, and none fills its data");
  if (!(counts[0] >= 1.0 && counts[0] < 4294967296.0 && counts[0] == std::floor(counts[0])))
    refuse_damaged_c3d(where_, "it has no frame count");
  return static_cast<std::size_t>(counts[0]);
}

void C3dTable::look_for_more_frames(std::size_t data_bytes) {
  if (data_bytes - frames_ * frame_bytes() <= c3d_block_bytes) return;
  std::size_t stored = data_bytes / frame_bytes();
  const auto is_padding = [&](std::size_t frame) {
    const std::string_view bytes = file_.text(data_ + frame * frame_bytes(), frame_bytes());
    return data_bytes - frame * frame_bytes() < c3d_block_bytes && bytes.find_first_not_of('\0') == bytes.npos;
  };
  while (stored > frames_ && is_padding(stored - 1)) --stored;
  if (stored == frames_) return;
  if (frames_ == max_short_frames)
    frames_ = stored;
  else
    add_caution(warnings_, "frames_left_out",
                "decid read " + std::to_string(frames_) + " frames, the file's count; the file stores " +
                    std::to_string(stored));
}

void C3dTable::name_points(const C3dParameters& parameters) {
  first_frame_ = static_cast<std::size_t>(
      frame_number(parameters, "TRIAL:ACTUAL_START_FIELD").value_or(file_.word(first_frame_at)));
  const std::map<std::string, std::string> others = units_of_kinds(parameters);
  const std::string length = parameters.text("POINT:UNITS");
  std::vector<std::string> full = parameters.texts("POINT:LABELS");
  full.resize(points_);
  std::vector<std::string> labels = full;
  remove_subject(labels);
  for (std::size_t point = 0; point < points_; ++point) {
    auto other = others.find(full[point]);
    if (other == others.end()) other = others.find(labels[point]);
    const std::string& unit = other == others.end() || labels[point].empty() ? length : other->second;
    const std::string label = labels[point].empty() ? "point " + std::to_string(point + 1) : labels[point];
    for (const char* axis : {"_x", "_y", "_z"}) names_.push_back(column_name(label + axis, unit));
  }
}

void C3dTable::name_channels(const C3dParameters& parameters) {
  std::vector<std::string> labels = parameters.texts("ANALOG:LABELS"), units = parameters.texts("ANALOG:UNITS");
  labels.resize(channels_);
  units.resize(channels_);
  gains_ = parameters.numbers("ANALOG:SCALE");
  offsets_ = parameters.numbers("ANALOG:OFFSET");
  for (const auto& [name, values] : {std::pair{"SCALE", &gains_}, {"OFFSET", &offsets_}})
    if (!values->empty() && values->size() < channels_)
      refuse_damaged_c3d(where_, std::string("ANALOG:") + name + " has " + std::to_string(values->size()) +
                                     " values for " + std::to_string(channels_) + " channels");
  gains_.resize(channels_, 1.0);
  offsets_.resize(channels_, 0.0);
  for (std::size_t channel = 0; channel < channels_; ++channel) {
    gains_[channel] *= parameters.number("ANALOG:GEN_SCALE", 1.0);
    if (is_unsigned_ && offsets_[channel] < 0.0) offsets_[channel] += 65536.0;
    names_.push_back(column_name(labels[channel].empty() ? "analog " + std::to_string(channel + 1) : labels[channel],
                                 units[channel]));
  }
}

/// Reads the sample rates of the rows. The header's counts serve where the parameters have none.
void C3dTable::read_rates(const C3dParameters& parameters) {
  const double samples = static_cast<double>(samples_), point = parameters.number("POINT:RATE", 0.0),
               analog = channels_ > 0 ? parameters.number("ANALOG:RATE", 0.0) : 0.0;
  const double rows_a_frame = points_ > 0 ? 1.0 : samples;
  if (point != 0.0) rates_.push_back({point * rows_a_frame, "POINT:RATE", true});
  const std::string per_frame =
      points_ > 0 && samples_ > 1 ? " over its " + std::to_string(samples_) + " samples per frame" : "";
  if (analog != 0.0) rates_.push_back({analog * rows_a_frame / samples, "ANALOG:RATE" + per_frame, true});
  if (rates_.empty()) rates_.push_back({file_.real(rate_at) * rows_a_frame, "the header", true});
}

bool C3dTable::is_faster(int column) const {
  return points_ > 0 && samples_ > 1 && static_cast<std::size_t>(column) >= 3 * points_;
}

std::string C3dTable::change_at(int column) const {
  if (!is_faster(column)) return {};
  return names_[static_cast<std::size_t>(column)] + " has " + std::to_string(samples_) +
         " samples per frame: decid resampled it to the points' rate";
}

std::string C3dTable::locate(std::size_t row) const {
  return points_ > 0 ? "frame " + std::to_string(first_frame_ + row) : "sample " + std::to_string(row + 1);
}

std::vector<double> C3dTable::coordinates(std::size_t point, std::size_t axis) const {
  std::vector<double> values(frames_);
  for (std::size_t frame = 0; frame < frames_; ++frame) {
    const std::size_t at = data_ + frame * frame_bytes() + 4 * point * value_bytes();
    const auto value = [&](std::size_t k) {
      return is_real_ ? file_.real(at + k * value_bytes()) : scale_ * file_.integer(at + k * value_bytes());
    };
    values[frame] = value(3) < 0.0 ? std::numeric_limits<double>::quiet_NaN()
                                   : value(axis);  // a negative residual marks a missing point
  }
  return values;
}

std::vector<double> C3dTable::samples(std::size_t channel) const {
  if (frames_ * samples_ > max_rows)
    throw Error(Code::file_too_large, where_, names_[3 * points_ + channel] + " has more than 10 million samples",
                "cut it to one trial");
  std::vector<double> values;
  values.reserve(frames_ * samples_);
  for (std::size_t frame = 0; frame < frames_; ++frame) {
    const std::size_t first = data_ + frame * frame_bytes() + 4 * points_ * value_bytes();
    for (std::size_t k = 0; k < samples_; ++k) {
      const std::size_t at = first + (k * channels_ + channel) * value_bytes();
      const int whole = is_unsigned_ ? int{file_.word(at)} : int{file_.integer(at)};
      values.push_back(((is_real_ ? file_.real(at) : whole) - offsets_[channel]) * gains_[channel]);
    }
  }
  return values;
}

std::vector<double> C3dTable::numbers(int column, Missing missing) const {
  const auto index = static_cast<std::size_t>(column);
  const bool faster = is_faster(column);
  std::vector<double> values = index < 3 * points_ ? coordinates(index / 3, index % 3) : samples(index - 3 * points_);
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (std::isfinite(values[k]) || (missing == Missing::kept && std::isnan(values[k]) && !faster)) continue;
    throw Error(std::isnan(values[k]) ? Code::value_missing : Code::value_invalid, where_,
                locate(faster ? k / samples_ : k) + ", " + names_[index] +
                    (std::isnan(values[k]) ? " is missing" : " is infinite"),
                remedy_for_missing);
  }
  return faster ? resample(values, static_cast<double>(samples_), 1.0, 0.0, frames_) : values;
}

}  // namespace decid::recording
