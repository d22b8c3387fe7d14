// Options of reading by name: see reading_option.hpp.
#include "identify/study/reading_option.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <initializer_list>

#include "base/text.hpp"
#include "identify/study/detail/text_key.hpp"

namespace decid {
namespace {

// A sheet's column has the option's name. No plain "leg", "hip", "ankle", "missing", "trial" or "start": sheets use
// these words for sides and findings of a person, a trial's number and a date.
constexpr auto option_names =
    std::to_array<std::string_view>({"column", "unit", "rate", "com_height", "skip_lines", "section", "missing_value",
                                     "fill_gaps", "begin", "tilt_column", "tilt_unit", "invert", "detrend",
                                     "leg_column", "trunk_column", "hip_column", "shoulder_column", "ankle_column"});

/// Reads the value of one option.
class Value {
 public:
  Value(const std::string& name, const std::string& text, const std::string& where)
      : name_(name), text_(text), where_(where) {}

  [[noreturn]] void refuse(const std::string& allowed) const {
    throw Error(Code::value_invalid, where_, name_ + " is '" + text_ + "'", "give " + allowed);
  }
  double number(double low, double high) const {
    std::string plain = text_;
    std::ranges::replace(plain, ',', '.');
    double value = 0.0;
    const auto [end, error] = std::from_chars(plain.data(), plain.data() + plain.size(), value);
    if (error != std::errc() || end != plain.data() + plain.size() || !(value >= low && value <= high))
      refuse(format("a number from %g to %g", low, high));
    return value;
  }
  recording::Unit angle() const {
    if (const std::optional<recording::Unit> unit = angle_unit_named(lower_case(text_))) return *unit;
    refuse("deg, rad or mrad");
  }

 private:
  const std::string &name_, &text_, &where_;
};

void set_unit(recording::RecordingOptions& made, const Value& value, const std::string& text) {
  made.unit = angle_unit_named(text);
  made.metres_per_unit = metres_of_unit(text);
  if (!made.unit && !made.metres_per_unit) value.refuse("deg, rad, mrad, mm, cm or m");
}

void set_invert(recording::RecordingOptions& made, const Value& value, const std::string& text) {
  const auto is_one_of = [&](std::initializer_list<const char*> words) {
    return std::ranges::find(words, text) != words.end();
  };
  const bool is_sway = is_one_of({"sway", "yes", "true", "ja"}), is_none = is_one_of({"none", "no", "false", "nein"});
  if (!is_sway && !is_none && text != "tilt" && text != "both")
    value.refuse("sway (or yes), tilt, both or none (or no)");
  made.invert_sway = is_sway || text == "both";
  made.invert_tilt = text == "tilt" || text == "both";
}

recording::Detrend detrend_of(const Value& value, const std::string& text) {
  if (text == "none" || text == "no") return recording::Detrend::none;
  if (text == "offset") return recording::Detrend::offset;
  if (text == "linear") return recording::Detrend::linear;
  value.refuse("none, offset or linear");
}

/// Returns the option's column, or null for an option that names none.
std::string* column_of(recording::RecordingOptions& made, const std::string& name) {
  if (name == "column") return &made.column;
  if (name == "section") return &made.section;
  if (name == "leg_column") return &made.leg_column;
  if (name == "trunk_column") return &made.trunk_column;
  if (name == "hip_column") return &made.hip_column;
  if (name == "shoulder_column") return &made.shoulder_column;
  if (name == "ankle_column") return &made.ankle_column;
  return nullptr;
}

}  // namespace

std::optional<recording::Unit> angle_unit_named(std::string_view name) {
  if (name == "deg") return recording::Unit::degree;
  if (name == "rad") return recording::Unit::radian;
  if (name == "mrad") return recording::Unit::milliradian;
  return {};
}

std::optional<double> metres_of_unit(std::string_view name) {
  if (name == "m") return 1.0;
  if (name == "cm") return 0.01;
  if (name == "mm") return 0.001;
  return {};
}

std::string find_reading_option(std::string_view column) {
  static const std::vector<std::string> keys = column_keys(option_names);
  const auto found = std::ranges::find(keys, column_key(column));
  return found == keys.end() ? std::string()
                             : std::string(option_names[static_cast<std::size_t>(found - keys.begin())]);
}

void set_reading_option(ReadOptions& made, const std::string& name, const std::string& text, const std::string& where) {
  const Value value(name, text, where);
  const std::string word = lower_case(text);
  recording::RecordingOptions& reading = made.recording;
  if (std::string* const column = column_of(reading, name)) {
    *column = text;
  } else if (name == "tilt_column") {
    reading.find_tilt = word != "none";
    reading.tilt_column = reading.find_tilt ? text : std::string();
  } else if (name == "unit") {
    set_unit(reading, value, word);
  } else if (name == "tilt_unit") {
    reading.tilt_unit = value.angle();
  } else if (name == "invert") {
    set_invert(reading, value, word);
  } else if (name == "rate") {
    reading.rate_hz = value.number(1.0, 1e5);
  } else if (name == "com_height") {
    reading.com_height_m = value.number(0.01, 3.0);
  } else if (name == "skip_lines") {
    reading.skip_lines = static_cast<int>(value.number(0.0, 1e6));
  } else if (name == "missing_value") {
    reading.missing_value = value.number(-1e300, 1e300);
  } else if (name == "fill_gaps") {
    reading.fill_gaps_s = value.number(0.0, recording::longest_gap_s);
  } else if (name == "begin") {
    made.trial.start_s = value.number(0.0, 1e6);
  } else if (name == "detrend") {
    made.trial.detrend = detrend_of(value, word);
  } else {
    throw Error(Code::setting_unknown, where, "'" + name + "' is not an option of reading", "name one of them");
  }
}

}  // namespace decid
