// Sample rates in words: see stated_rate.hpp. The phrases come from exports of motion capture, force plates, inertial
// sensors and amplifiers, in English, German, French, Italian and Spanish.
#include "recording/detail/stated_rate.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "recording/table/cells.hpp"
#include "recording/table/columns.hpp"

namespace decid::recording {

namespace {

enum class Meaning { none, bare_rate, rate, interval };

/// Returns the meaning of a phrase, given as its lower-case letters only.
Meaning meaning_of(std::string phrase) {
  for (const std::string_view unit : {"inhz", "inhertz", "hz", "hertz"}) {
    if (phrase.size() > unit.size() && phrase.ends_with(unit)) {
      phrase.resize(phrase.size() - unit.size());
      break;
    }
  }
  if (one_of(phrase, {"rate", "frequency", "freq", "frequenz", "fs", "fps", "sr", "sf"})) return Meaning::bare_rate;
  if (one_of(phrase, {"abtastfrequenz", "abtastrate", "messfrequenz", "messrate", "bildrate", "bildfrequenz",
                      "aufnahmerate", "aufnahmefrequenz", "samplespersecond", "framespersecond", "samplepersecond",
                      "framepersecond", "sps", "fr\u00e9quenced\u00e9chantillonnage", "frequencedechantillonnage",
                      "frequenzadicampionamento", "frecuenciademuestreo"}))
    return Meaning::rate;
  if (one_of(phrase, {"interval", "sampleinterval", "samplinginterval", "sampleperiod", "samplingperiod", "deltax",
                      "dt", "ts", "timestep", "abtastintervall", "secsample", "msecsample", "ssample", "mssample"}))
    return Meaning::interval;
  for (const std::string_view noun : {"rate", "frequency", "freq", "frequenz"}) {
    if (!phrase.ends_with(noun)) continue;
    phrase.resize(phrase.size() - noun.size());
    const bool known = one_of(
        phrase, {"sample",       "samples", "sampling",    "data",        "frame",     "frames",  "capture",
                 "captureframe", "export",  "exportframe", "acquisition", "recording", "update",  "output",
                 "scan",         "video",   "camera",      "marker",      "mocap",     "logging", "measurement"});
    return known ? Meaning::rate : Meaning::none;
  }
  return Meaning::none;
}

struct Quantity {
  double value;
  std::string unit;  ///< lower case: "hz", "msec/sample"
};

/// Reads "100", "100 Hz" and "100.0Hz": a number, and nothing else except a unit.
std::optional<Quantity> quantity_in(std::string_view field) {
  const std::size_t end = field.find_first_not_of("+-.,0123456789eE");
  std::size_t length = std::min(end, field.size());
  while (length > 0 && !parse_number(field.substr(0, length)).is_number) --length;  // "10e" of "10 euros"
  if (length == 0) return {};
  Quantity found{parse_number(field.substr(0, length)).value, lower_case(std::string(trim(field.substr(length))))};
  if (found.unit.starts_with("hz ")) found.unit = "hz";  // a remark may follow
  return found;
}

/// Returns the seconds of the unit at the end of a phrase or a quantity.
std::optional<double> seconds_in(std::string_view unit) {
  if (one_of(unit, {"s", "sec", "secs", "second", "seconds", "sekunden", "sec/sample", "s/sample"})) return 1.0;
  if (one_of(unit, {"ms", "msec", "msecs", "milliseconds", "msec/sample", "ms/sample"})) return 1e-3;
  if (one_of(unit, {"us", "usec", "microseconds", "\xC2\xB5s", "usec/sample", "us/sample"})) return 1e-6;
  return {};
}

void add(std::string_view phrase, const Quantity& quantity, std::vector<StatedRate>& rates) {
  std::string text = letters_of(phrase);
  std::optional<double> unit_s = seconds_in(quantity.unit);
  if (const auto parts = words(phrase); parts.size() > 1 && quantity.unit.empty() && seconds_in(parts.back())) {
    unit_s = seconds_in(parts.back());
    text.resize(text.size() - parts.back().size());
  }
  const Meaning meaning = meaning_of(text);
  double hz = 0.0;
  if (meaning == Meaning::rate || meaning == Meaning::bare_rate) {
    if (!one_of(quantity.unit, {"", "hz", "hertz", "1/s", "/s", "fps", "sps", "samples/s", "frames/s", "khz"})) return;
    hz = quantity.unit == "khz" ? 1e3 * quantity.value : quantity.value;
  } else if (meaning == Meaning::interval) {
    // Programs that write these names use seconds.
    if (!unit_s && quantity.unit.empty() && one_of(text, {"deltax", "dt", "ts"})) unit_s = 1.0;
    if (!unit_s) return;
    hz = near_whole(1.0 / (quantity.value * *unit_s));
  }
  if (is_sample_rate(hz)) rates.push_back({hz, std::string(phrase), meaning != Meaning::bare_rate});
}

}  // namespace

// A comma between digits separates only if another comma clearly does.
std::vector<std::string_view> fields_of(std::string_view line) {
  line.remove_prefix(std::min(line.find_first_not_of("#%/ \t"), line.size()));
  const auto is_digit = [&](std::size_t i) { return i < line.size() && line[i] >= '0' && line[i] <= '9'; };
  const auto within_number = [&](std::size_t i) {
    return line[i] == ',' && i > 0 && is_digit(i - 1) && is_digit(i + 1);
  };
  bool commas_separate = false;
  for (std::size_t i = 0; i < line.size(); ++i) commas_separate |= line[i] == ',' && !within_number(i);
  std::vector<std::string_view> fields;
  std::size_t begin = 0;
  for (std::size_t i = 0; i <= line.size(); ++i) {
    const bool ends = i == line.size() || std::string_view("\t;:=\"").find(line[i]) != std::string_view::npos ||
                      (line[i] == ',' && (commas_separate || !within_number(i)));
    if (!ends) continue;
    if (const auto field = trim(line.substr(begin, i - begin)); !field.empty()) fields.push_back(field);
    begin = i + 1;
  }
  return fields;
}

void add_stated_rates(std::string_view line, std::vector<StatedRate>& rates) {
  const std::vector<std::string_view> fields = fields_of(line);
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::string_view field = fields[i];
    const auto parts = words(field);
    const bool ends_in_unit = parts.size() > 1 && seconds_in(parts.back());
    if (i + 1 < fields.size() && (ends_in_unit || meaning_of(letters_of(field)) != Meaning::none)) {
      if (const auto quantity = quantity_in(fields[i + 1])) add(field, *quantity, rates);
      continue;
    }
    // "Sampling rate 100 Hz", "30 FPS", "10 msec/sample"
    const std::size_t number = field.find_first_of("0123456789");
    if (number == std::string_view::npos) continue;
    if (number > 0 && field[number - 1] == ' ') {
      if (const auto quantity = quantity_in(field.substr(number))) add(trim(field.substr(0, number)), *quantity, rates);
    } else if (const auto quantity = quantity_in(field); quantity && !quantity->unit.empty()) {
      const std::string unit = quantity->unit;
      add(unit, seconds_in(unit) ? *quantity : Quantity{quantity->value, {}}, rates);
    }
  }
}

std::vector<StatedRate> candidates(const std::vector<StatedRate>& rates) {
  const bool any_plain = std::ranges::any_of(rates, &StatedRate::is_plain);
  std::vector<StatedRate> found;
  for (const StatedRate& rate : rates) {
    const auto is_same = [&](const StatedRate& other) {
      return std::abs(other.hz - rate.hz) <= rate_tolerance * rate.hz;
    };
    if ((rate.is_plain || !any_plain) && std::ranges::none_of(found, is_same)) found.push_back(rate);
  }
  return found;
}

std::string to_list(const std::vector<StatedRate>& rates) {
  std::string list;
  for (const StatedRate& rate : rates)
    list += (list.empty() ? "'" : ", '") + rate.phrase + "' " + six_digits(rate.hz) + " Hz";
  return list;
}

}  // namespace decid::recording
