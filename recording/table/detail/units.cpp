// Units in the names of columns: see units.hpp.
#include "recording/table/detail/units.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"
#include "recording/table/columns.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::recording {

namespace {

std::optional<Unit> find_angle_unit(std::string_view word) {
  if (one_of(word, {"deg", "degree", "degrees", "\xC2\xB0", "grad"})) return Unit::degree;
  if (one_of(word, {"rad", "radian", "radians"})) return Unit::radian;
  if (one_of(word, {"mrad", "millirad", "milliradian", "milliradians"})) return Unit::milliradian;
  return {};
}

/// Returns the word that is the unit of angles: the last, else the first of several, as in "mrad_sway".
std::optional<std::size_t> place_of_unit(const std::vector<std::string>& parts) {
  if (find_angle_unit(parts.back())) return parts.size() - 1;
  if (parts.size() > 1 && parts.front() != "grad" && find_angle_unit(parts.front())) return 0;
  return {};
}

std::optional<double> metres_of(std::string_view word) {
  if (one_of(word, {"mm", "millimeter", "millimetre", "millimeters", "millimetres"})) return 1e-3;
  if (one_of(word, {"cm", "centimeter", "centimetre", "centimeters", "centimetres", "zentimeter"})) return 1e-2;
  if (one_of(word, {"m", "meter", "metre", "meters", "metres"})) return 1.0;
  return {};
}

/// Returns true for "10", "0", "1e", "e3", "x100" and "\u00D710", the words of factors.
bool is_factor_word(std::string_view word) {
  for (const std::string_view times : {"x", "\u00D7"})
    if (word.starts_with(times)) word.remove_prefix(times.size());
  return !word.empty() && word.find_first_not_of("0123456789e") == word.npos && word != "e";
}

/// Returns true for "x10", "x1000" and "1e3", which are factors without brackets too.
bool is_power_of_ten(std::string_view word) {
  for (const std::string_view times : {"x", "\u00D7"}) {
    const std::string_view number = word.starts_with(times) ? word.substr(times.size()) : std::string_view();
    if (number.size() > 1 && number.front() == '1' && number.find_first_not_of('0', 1) == number.npos) return true;
  }
  return word.size() > 2 && word.starts_with("1e") && word.find_first_not_of("0123456789", 2) == word.npos;
}

/// Returns true for a unit with a factor: "(deg x10)", "[1/10 deg]", "(rad*1e-3)", "[10^-3 rad]", "deg_x100".
bool has_factor(std::string_view name) {
  const auto is_unit = [](const std::string& word) { return find_angle_unit(word) || metres_of(word); };
  const std::string_view unit = unit_behind(name);
  const bool multiplies = unit.find_first_of("*/^x") != unit.npos || unit.find("\u00D7") != unit.npos ||
                          unit.find_first_of("0123456789") == 0;
  const std::vector<std::string> within = words(unit);
  if (multiplies && within.size() > 1 && std::ranges::any_of(within, is_unit) &&
      std::ranges::any_of(within, is_factor_word) &&
      std::ranges::all_of(within, [&](const std::string& word) { return is_unit(word) || is_factor_word(word); }))
    return true;
  const std::vector<std::string> parts = words(name);
  for (std::size_t i = 1; i < parts.size(); ++i)
    if (is_unit(parts[i - 1]) && is_power_of_ten(parts[i])) return true;
  return name.find("10^") != name.npos && std::ranges::any_of(parts, is_unit);
}

/// Returns the quantity of a force plate's channel, "Fz", "FP1_Fx" and "My2", or nullptr. "CoMx" is one word. A
/// name with a body's quantity, as "my sway", is no channel.
const char* quantity_of_channel(const std::vector<std::string>& parts) {
  const auto is_of_body = [](const std::string& word) {
    return one_of(word, {"angle", "sway", "tilt", "lean", "com", "cog", "winkel", "deg"});
  };
  // "data.My" is a channel of the structure `data`.
  if (std::ranges::any_of(parts, is_of_body) || (parts.front() != "data" && parts.back() == "data")) return nullptr;
  for (std::string_view word : parts) {
    while (!word.empty() && word.back() >= '0' && word.back() <= '9') word.remove_suffix(1);
    if (one_of(word, {"fx", "fy", "fz"})) return a_force;
    if (one_of(word, {"mx", "my", "mz"})) return a_torque;
  }
  return nullptr;
}

/// Returns true for "pitch_rate", "pitchRate", "body_rate", "dpitch", "omega" and "wy", but not for "sample_rate".
bool is_angular_rate(const std::vector<std::string>& all) {
  const auto is_turning = [](std::string_view word) {
    return one_of(word, {"pitch", "roll", "yaw", "sway", "tilt", "lean", "body", "com", "cog", "angle", "angular",
                         "trunk", "torso", "leg", "hip", "ankle", "platform", "theta", "phi"});
  };
  if (one_of(all.back(), {"wx", "wy", "wz"})) return true;
  bool has_rate = false, turns = false, is_of_samples = false;
  for (const std::string& word : all) {
    if (one_of(word, {"omega", "omegax", "omegay", "omegaz"})) return true;
    if (word.starts_with('d') && one_of(std::string_view(word).substr(1), {"pitch", "sway", "tilt", "theta"}))
      return true;
    if (word.ends_with("rate") && is_turning(std::string_view(word).substr(0, word.size() - 4))) return true;
    has_rate = has_rate || word == "rate";
    turns = turns || is_turning(word);
    is_of_samples = is_of_samples || one_of(word, {"sample", "samples", "sampling", "frame", "frames", "update"});
  }
  return has_rate && turns && !is_of_samples;
}

/// Returns the quantity that a unit measures ("mV": "a voltage"). Returns nullptr for units of angles, for mm, cm and
/// m, and for text that is not a unit ("AP", "left").
const char* quantity_of_unit(std::string_view text) {
  std::string unit = "|";
  for (const char c : lower_case(std::string(text)))
    if (c != ' ') unit += c;
  if (unit.size() == 1) return nullptr;
  unit += '|';
  for (const auto& [quantity, units] :
       {std::pair{"a voltage", "|v|mv|uv|\xC2\xB5v|\xCE\xBCv|volt|volts|"},
        {"a current", "|ma|ua|\u00B5a|\u03BCa|"},
        {a_force, "|n|kn|lb|lbs|lbf|"},
        {a_torque, "|nm|n*m|n.m|nmm|n*mm|n.mm|nm/kg|"},
        {"a pressure", "|pa|kpa|"},
        {"a velocity", "|m/s|mm/s|cm/s|"},
        {"an acceleration", "|m/s^2|m/s2|g|"},
        {"a mass", "|kg|"},
        {"a fraction", "|%|%bw|%bh|%height|percent|pct|prozent|"},
        {"a temperature", "|\u00B0c|degc|celsius|\u00B0f|degf|"},
        {"a frequency", "|hz|khz|"},
        {"a length in neither mm, cm nor m", "|in|inch|inches|ft|feet|um|\xC2\xB5m|\xCE\xBCm|km|"},
        {"in pixels", "|px|pixel|pixels|"},
        {"in counts", "|counts|lsb|"},
        {"in decibels", "|db|"},
        {"in arbitrary units", "|a.u.|a.u|au|arb.u.|"}})
    if (std::string_view(units).find(unit) != std::string_view::npos) return quantity;
  return nullptr;
}

}  // namespace

std::string_view unit_behind(std::string_view name) {
  if (name.empty() || (name.back() != ')' && name.back() != ']')) return {};
  const std::size_t open = name.find_last_of(name.back() == ')' ? '(' : '[');
  return open == std::string_view::npos ? std::string_view() : name.substr(open + 1, name.size() - open - 2);
}

const char* other_quantity(std::string_view name) {
  const std::vector<std::string> parts = words(name);
  const std::string& last = parts.back();
  const std::vector<std::string> all = words_in(name);
  for (const std::string& word : all)
    if (one_of(word, {"cop", "copx", "copy", "copap", "copml"})) return centre_of_pressure;
  if (const char* quantity = quantity_of_unit(unit_behind(name))) return quantity;
  // Without brackets these letters often have other meanings: "sway_PA" is a direction, "sway_ma" a moving average.
  if (parts.size() > 1 && last.size() > 1 && !one_of(last, {"in", "pa", "ma", "kn", "feet"}))
    if (const char* quantity = quantity_of_unit(last)) return quantity;
  if (parts.size() > 1 && metres_of(last)) return "a length";
  if (name.ends_with("_V")) return "a voltage";
  if (is_angular_rate(all)) return "a velocity";
  for (const std::string& word : all) {
    for (const char* quantity : {"velocity", "speed", "acceleration"})
      if (word.find(quantity) != std::string::npos)
        return word.ends_with("acceleration") ? "an acceleration" : "a velocity";
    if (one_of(word, {"vel", "swayvel", "comvel", "angvel", "dot", "geschwindigkeit", "winkelgeschwindigkeit"}))
      return "a velocity";
    const bool is_integrated = unit_in(name) && std::ranges::find(all, "angle") != all.end();
    if (one_of(word, {"gyro", "gyr"}) && !is_integrated) return "a velocity";
    if (one_of(word, {"acc", "accel", "accx", "accy", "accz", "ddot", "beschleunigung"})) return "an acceleration";
    if (one_of(word, {"torque", "moment", "drehmoment", "moments"})) return a_torque;
    if (one_of(word, {"force", "forces", "grf", "kraft"})) return a_force;
    if (word == "emg") return "muscle activity";
    if (one_of(word, {"ecg", "ekg", "bpm", "heartrate", "herzfrequenz", "puls", "pulse"}) ||
        (word == "hr" && all.size() == 1) || (word == "heart" && all.size() > 1))
      return "a heart's signal";
    if (one_of(word, {"respiration", "breathing", "atmung"}) || (word == "resp" && all.size() == 1)) return "breathing";
    if (one_of(word, {"eda", "gsr"})) return "a skin conductance";
    if (word == "eeg") return "brain activity";
    if (one_of(word, {"temperature", "temperatur"})) return "a temperature";
    if (one_of(word, {"std", "sd", "stdev"})) return "a standard deviation";
  }
  // "deg/s", "deg_s", "rad per s", "deg/s^2"
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const bool after_angle =
        find_angle_unit(parts[i - 1]) || (parts[i - 1] == "per" && i > 1 && find_angle_unit(parts[i - 2]));
    if (after_angle && one_of(parts[i], {"s", "sec", "second", "s2"})) {
      return parts[i] == "s2" || (i + 1 < parts.size() && parts[i + 1] == "2") ? "an acceleration" : "a velocity";
    }
  }
  if (last == "dps") return "a velocity";
  return unit_in(name) ? nullptr : quantity_of_channel(parts);
}

std::optional<Unit> unit_in(std::string_view name) {
  const std::vector<std::string> parts = words(name);
  const std::optional<std::size_t> place = place_of_unit(parts);
  return place ? find_angle_unit(parts[*place]) : std::nullopt;
}

std::optional<Unit> find_unit(const std::string& name, std::optional<Unit> given, const std::string& where,
                              const std::string& setting_name) {
  if (given) return given;
  if (one_of(words(name).back(),
             {"gon", "arcmin", "arcsec", "mdeg", "millideg", "millidegrees", "cdeg", "turn", "turns", "rev",
              "revolutions", "urad", "\u00B5rad", "\u03BCrad", "microrad", "microradians", "m\u00B0"}) ||
      (has_factor(name) &&
       std::ranges::any_of(words(name), [](const std::string& word) { return find_angle_unit(word).has_value(); })))
    throw Error(Code::unit_unknown, where, name + " is neither in degrees nor in radians by its name",
                "convert it to one of them");
  if (const char* quantity = other_quantity(name)) {
    throw Error(Code::column_unsuitable, where, name + " is " + quantity + " by its name, not an angle",
                std::string_view(quantity) == "a length" && setting_name == setting("unit")
                    ? "give the height of the centre of mass above the ankles as " + setting("com_height") + ", or " +
                          setting("unit") + " if it is an angle"
                : quantity == centre_of_pressure
                    ? "estimate the centre of mass first: a force plate's centre of pressure moves farther and faster"
                    : "name a column of angles, or give " + setting_name + " if it is one");
  }
  return unit_in(name);
}

Unit angle_unit(const Table& table, int column, std::optional<Unit> given, const std::string& setting_name,
                Recording& recording) {
  const std::string& name = table.name(column);
  const std::optional<Unit> named = unit_in(name);
  const char* const quantity = other_quantity(name);
  if (given && quantity != nullptr)
    add_caution(recording.warnings, "unit_differs",
                name + " is " + quantity + " by its name, not an angle; decid reads it as an angle in " + setting_name +
                    (quantity == centre_of_pressure ? ": the model needs the sway of the body's centre of mass" : ""));
  else if (given && named && *named != *given)
    add_caution(recording.warnings, "unit_differs",
                name + " has a unit in its name that differs from " + setting_name + "; decid uses " + setting_name);
  if (const std::optional<Unit> unit = find_unit(name, given, recording.file, setting_name)) return *unit;
  if (const std::optional<Unit> unit = table.unit()) return *unit;
  add_info(recording.warnings, "unit_assumed", "the name of " + name + " has no unit: decid assumes degrees");
  return Unit::degree;
}

std::optional<double> find_metres_per_unit(std::string_view name) {
  const std::vector<std::string> parts = words(name);
  return parts.size() > 1 && !has_factor(name) ? metres_of(parts.back()) : std::nullopt;
}

double rad_in(Unit unit) {
  if (unit == Unit::degree) return sim::rad_per_deg;
  return unit == Unit::milliradian ? 1e-3 : 1.0;
}

std::string name_before_unit(std::string_view name) {
  if (name.empty() || (name.back() != ')' && name.back() != ']')) return std::string(name);
  const std::size_t open = name.find_last_of(name.back() == ')' ? '(' : '[');
  if (open == std::string_view::npos || open == 0) return std::string(name);
  name = name.substr(0, open);
  while (!name.empty() && name.back() == ' ') name.remove_suffix(1);
  return std::string(name);
}

std::string name_without_unit(std::string_view name) {
  std::vector<std::string> parts = words(name);
  const std::optional<std::size_t> unit = place_of_unit(parts);
  if (parts.size() > 1 && (unit || find_metres_per_unit(name)))
    parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(unit.value_or(parts.size() - 1)));
  return decid::joined(parts, "_");
}

}  // namespace decid::recording
