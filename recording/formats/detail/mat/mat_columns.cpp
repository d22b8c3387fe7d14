// Columns of a MAT-file: see mat_columns.hpp. The forms follow the manuals of ADInstruments' "Export to MATLAB"
// (LabChart 7 and 8), BIOPAC's AcqKnowledge, Qualisys Track Manager, and Simulink's "structure with time".
#include "recording/formats/detail/mat/mat_columns.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <tuple>

#include "base/error.hpp"
#include "recording/table/cells.hpp"
#include "recording/table/columns.hpp"

namespace decid::recording {
namespace {

using Kind = MatVariable::Kind;
using Variables = std::vector<MatVariable>;

const char* to_text(Kind kind) {
  constexpr const char* names[] = {"numbers", "complex", "text", "cell", "struct", "sparse", "object", "function"};
  return names[static_cast<std::size_t>(kind)];  // in the order of Kind
}

bool is_rate(const std::string& plain) {
  return one_of(plain,
                {"fs", "sr", "sf", "fs_hz", "rate", "rate_hz", "freq", "frequency", "framerate", "frame_rate"}) ||
         one_of(plain,
                {"fsample", "srate", "sample_rate", "samplerate", "sample_rate_hz", "sample_frequency", "samplingrate",
                 "sampling_rate", "sampling_rate_hz", "samplingfrequency", "sampling_frequency"});
}

// Variables that LabChart and Qualisys write. All others are the user's and become columns.
constexpr std::string_view labchart_variables =
    "|data|datastart|dataend|titles|rangemin|rangemax|unittext|unittextmap|samplerate|tickrate|blocktimes|scaleunits|"
    "scaleoffset|firstsampleoffset|com|comtext|";
constexpr std::string_view marker_variables = "|Labels|Data|Type|Name|Positions|Rotations|RPYs|Residual|Filter|";

MatVariable* find(Variables& variables, std::string_view name) {
  const auto found = std::ranges::find(variables, name, &MatVariable::name);
  return found == variables.end() ? nullptr : &*found;
}

/// Returns the variable's first row of text; empty for other data.
std::string words_of(const MatVariable* variable) {
  return variable == nullptr || variable->text.empty() || variable->kind != Kind::text ? std::string()
                                                                                       : variable->text.front();
}

/// Returns a list of texts: the rows of a character matrix, or a cell array of texts; empty for other data.
std::vector<std::string> to_list(const MatVariable* variable) {
  if (variable == nullptr) return {};
  if (variable->kind == Kind::text) return variable->text;
  std::vector<std::string> list;
  if (variable->kind != Kind::cell) return list;
  for (const MatVariable& cell : variable->fields) {
    if (cell.kind != Kind::text && cell.count() != 0) return {};
    list.push_back(words_of(&cell));
  }
  return list;
}

/// Returns the number of a 1 x 1 variable; nothing for other data.
std::optional<double> scalar_of(const MatVariable* variable) {
  if (variable == nullptr || variable->values.size() != 1 || !std::isfinite(variable->values[0])) return {};
  return variable->values[0];
}

/// Returns a label with its unit, unless the label ends in a unit.
std::string labelled(const std::string& label, const std::string& unit) {
  return unit.empty() || unit_in(label) || find_metres_per_unit(label) ? label : label + " (" + unit + ")";
}

/// Collects the columns of a file's variables.
class Collector {
 public:
  explicit Collector(const std::string& where) : where_(where) {}

  /// Adds variables of a file, or fields of a structure.
  void add_all(Variables& variables, const MatScope& scope) {
    const std::string_view own = add_labchart(variables)         ? labchart_variables
                                 : add_markers(variables, scope) ? marker_variables
                                                                 : std::string_view();
    add_simulink(variables, scope);
    add_interval(variables, scope);
    const Labels labels = labels_in(variables);
    for (MatVariable& variable : variables) {
      describe(variable, made.variables);
      if (variable.values.size() < 2 || own.find("|" + variable.name + "|") == own.npos) add(variable, scope, labels);
    }
  }

  MatColumns made;

 private:
  struct Labels {
    std::vector<std::string> names;
    std::string unit(std::size_t i) const { return i < units.size() ? units[i] : std::string(); }
    std::vector<std::string> units;
  };

  std::string path_to(const std::string& name) const {
    return outer_.empty() ? name : name.starts_with('(') || name.starts_with('{') ? outer_ + name : outer_ + "." + name;
  }

  /// Returns a description such as "trial.x (12 x 2 complex)".
  std::string described(const MatVariable& variable) const {
    std::string size = std::to_string(variable.height) + " x " + std::to_string(variable.width);
    if (variable.pages != 1) size += " x " + std::to_string(variable.pages);
    if (!variable.is_matrix) size = "more than three dimensions,";
    if (variable.kind == Kind::object && !variable.text.empty()) size = variable.text.front();
    return path_to(variable.name) + " (" + size + " " + to_text(variable.kind) + ")";
  }

  void describe(const MatVariable& variable, std::string& list) const {
    if (!variable.name.empty() && list.size() < 200) list += (list.empty() ? "" : ", ") + described(variable);
  }

  /// Returns the lists of names and of units next to a matrix.
  static Labels labels_in(Variables& variables) {
    Labels labels;
    // A timeseries object as a structure has names; elsewhere a name may be a person's.
    if (find(variables, "Time") != nullptr && find(variables, "Data") != nullptr) {
      labels.names = to_list(find(variables, "Name"));
      if (MatVariable* info = find(variables, "DataInfo")) labels.units = to_list(find(info->fields, "Units"));
    }
    for (const MatVariable& variable : variables) {
      const std::string plain = name_without_unit(variable.name);
      if (labels.names.empty() &&
          one_of(plain, {"labels",       "label",          "names",         "channels",     "channel_names",
                         "channelnames", "channel_labels", "titles",        "colheaders",   "headers",
                         "header",       "columns",        "column_names",  "columnnames",  "varnames",
                         "variables",    "variable_names", "variablenames", "signal_names", "signalnames"}))
        labels.names = to_list(&variable);
      if (labels.units.empty() && one_of(plain, {"units", "unit", "channel_units", "channelunits"}))
        labels.units = to_list(&variable);
    }
    return labels;
  }

  MatColumn& add_column(const std::string& name, const std::string& path, const MatScope& scope, bool is_named) {
    return made.columns.emplace_back(MatColumn{name, path, scope, elements_, is_named, {}, {}});
  }

  void add(MatVariable& variable, const MatScope& scope, const Labels& labels) {
    const bool is_strange = one_of(to_text(variable.kind), {"complex", "sparse", "object"});
    if (is_strange || !variable.is_matrix) return describe(variable, made.unread);
    if (!variable.fields.empty()) return add_inner(variable, scope);
    if (variable.values.size() == 1) return add_scalar(variable, scope);
    if (variable.values.empty()) return;
    // Elements of arrays also hold pairs of numbers: limits, window positions.
    constexpr std::size_t min_samples = 16;
    if (!elements_.empty() && variable.values.size() < min_samples) return;
    // A matrix of one row and many pages is a column of that row.
    if (variable.pages > 1 && variable.height == 1) {
      variable.height = variable.width;
      variable.width = variable.pages;
      variable.pages = 1;
    }
    if (variable.pages > 1) return add_pages(variable, scope, labels);
    if (variable.height == 1 || variable.width == 1) return add_vector(variable, scope, labels);
    add_matrix(variable, scope, labels);
  }

  void add_inner(MatVariable& variable, const MatScope& scope) {
    const std::string outer = outer_;
    outer_ = path_to(variable.name);
    const std::string path = outer_;
    MatScope inner = scope;
    inner.push_back(variable.name);
    if (variable.kind == Kind::structure && variable.fields.front().name != "(1)") {
      add_all(variable.fields, inner);
    } else {
      const std::size_t before = made.columns.size();
      for (std::size_t i = 0; i < variable.fields.size(); ++i) {
        elements_.emplace_back(path, i);
        Variables one;
        one.push_back(std::move(variable.fields[i]));
        add(one.front(), inner, {});
        elements_.pop_back();
      }
      if (variable.fields.size() > 1 && made.columns.size() > before)
        made.arrays.push_back({path, variable.fields.size()});
    }
    outer_ = outer;
  }

  void add_scalar(const MatVariable& variable, const MatScope& scope) {
    const double value = variable.values.front();
    const std::string plain = name_without_unit(variable.name), path = path_to(variable.name);
    if (is_rate(plain) && std::isfinite(value) && value > 0.0)
      made.rates.push_back({{value, path, !one_of(plain, {"rate", "freq", "frequency"})}, scope});
    if (one_of(plain, {"ts", "dt", "sampling_interval", "sample_interval", "sample_time"}) &&
        is_sample_rate(1.0 / value))
      made.rates.push_back({{near_whole(1.0 / value), path, true}, scope});
  }

  /// Adds "isi" and its unit, AcqKnowledge's sampling interval.
  void add_interval(Variables& variables, const MatScope& scope) {
    const std::optional<double> interval = scalar_of(find(variables, "isi"));
    const std::string unit = words_of(find(variables, "isi_units"));
    if (!interval || !one_of(unit, {"s", "sec", "seconds", "ms", "msec", "milliseconds", "us"})) return;
    const double rate_hz = 1.0 / (*interval * time_unit_s(unit));
    if (is_sample_rate(rate_hz)) made.rates.push_back({{near_whole(rate_hz), path_to("isi"), true}, scope});
  }

  void add_vector(MatVariable& variable, const MatScope& scope, const Labels& labels) {
    const bool is_labelled = labels.names.size() == 1 && !labels.names[0].empty() &&
                             one_of(name_without_unit(variable.name), {"data", "values"});
    const bool is_cell = variable.name.starts_with('{');
    const std::string name = is_labelled ? labelled(labels.names[0], labels.unit(0)) : variable.name;
    add_column(is_cell ? outer_name(scope) + name : name, path_to(variable.name), scope, true).values =
        std::move(variable.values);
  }

  static std::string outer_name(const MatScope& scope) { return scope.empty() ? std::string() : scope.back(); }

  void add_matrix(MatVariable& variable, const MatScope& scope, const Labels& labels) {
    const std::size_t height = variable.height, width = variable.width, names = labels.names.size();
    const bool names_rows = names == height && names != width, names_columns = names == width && names != height;
    const bool wide = names_rows || (!names_columns && width > height);
    const std::size_t signals = wide ? height : width, samples = wide ? width : height;
    const bool is_labelled = names == signals;
    const bool is_cell = variable.name.starts_with('{');
    // A single name for several signals names the matrix, as in Simulink.
    const std::string shown = names == 1 && !labels.names[0].empty() ? labels.names[0]
                              : is_cell                              ? outer_name(scope) + variable.name
                                                                     : variable.name;
    const std::string path = path_to(variable.name);
    MatScope inner = scope;
    inner.push_back(variable.name);
    for (std::size_t s = 0; s < signals && made.columns.size() <= max_mat_columns; ++s) {
      const std::string index = wide ? "(" + std::to_string(s + 1) + ",:)" : "(:," + std::to_string(s + 1) + ")";
      const bool has_label = is_labelled && !labels.names[s].empty();
      if (!is_labelled) elements_.emplace_back(path, s);
      MatColumn& column = add_column(has_label ? labelled(labels.names[s], labels.unit(s)) : shown + index,
                                     path + index, inner, has_label);
      if (!is_labelled) elements_.pop_back();
      column.values.resize(samples);
      for (std::size_t k = 0; k < samples; ++k)
        column.values[k] = variable.values[wide ? k * height + s : s * height + k];
    }
    if (!is_labelled) made.arrays.push_back({path, signals, true});
    variable.values = {};
  }

  /// Adds samples x channels x trials, or channels x samples x trials. Skips other arrays: which dimension holds the
  /// samples is ambiguous.
  void add_pages(const MatVariable& variable, const MatScope& scope, const Labels& labels) {
    const std::size_t height = variable.height, width = variable.width, pages = variable.pages;
    const bool wide = width > height;
    const std::size_t channels = wide ? height : width, samples = wide ? width : height;
    if (samples <= pages || samples <= channels || channels * pages > max_mat_columns)
      return describe(variable, made.unread);
    const std::string path = path_to(variable.name);
    for (std::size_t page = 0; page < pages; ++page) {
      elements_.emplace_back(path, page);
      MatScope inner = scope;
      inner.push_back(variable.name);
      inner.push_back("(" + std::to_string(page + 1) + ")");
      for (std::size_t c = 0; c < channels && made.columns.size() <= max_mat_columns; ++c) {
        const std::string number = std::to_string(c + 1);
        const std::string index = (wide ? "(" + number + ",:," : "(:," + number + ",") + std::to_string(page + 1) + ")";
        const bool has_label = labels.names.size() == channels && !labels.names[c].empty();
        MatColumn& column = add_column(has_label ? labelled(labels.names[c], labels.unit(c)) : variable.name + index,
                                       path + index, inner, has_label);
        column.values.resize(samples);
        for (std::size_t k = 0; k < samples; ++k)
          column.values[k] = variable.values[(page * width + (wide ? k : c)) * height + (wide ? c : k)];
      }
      elements_.pop_back();
    }
    made.arrays.push_back({path, pages});
  }

  /// Adds Simulink's data: time, and signals with values and a label each. Signals are not trials.
  void add_simulink(Variables& variables, const MatScope& scope) {
    MatVariable* signals = find(variables, "signals");
    if (signals == nullptr || signals->fields.empty() || find(variables, "time") == nullptr) return;
    const bool several = signals->fields.front().name == "(1)";
    std::vector<MatVariable*> all{signals};
    if (several) all.clear();
    for (MatVariable& field : signals->fields)
      if (several) all.push_back(&field);
    const std::string outer = outer_;
    MatScope inner = scope;
    inner.emplace_back("signals");
    bool any = false;
    for (MatVariable* signal : all) {
      MatVariable* values = find(signal->fields, "values");
      const std::string label = words_of(find(signal->fields, "label"));
      if (values == nullptr || values->values.size() < 2) continue;
      outer_ = outer;
      outer_ = path_to(several ? "signals" + signal->name : "signals");
      add(*values, inner, {{label}, {}});
      any = true;
    }
    outer_ = outer;
    if (any) signals->fields.clear();
  }

  /// Adds Qualisys' data: Labels and Data of markers x (X, Y, Z, residual) x frames in mm; Name, Positions and RPYs of
  /// bodies.
  bool add_markers(Variables& variables, const MatScope& scope) {
    const std::array positions{" X (mm)", " Y (mm)", " Z (mm)"}, angles{" Roll (deg)", " Pitch (deg)", " Yaw (deg)"};
    bool any = false;
    for (const auto& [list, field, parts] :
         {std::tuple{"Labels", "Data", positions}, {"Name", "Positions", positions}, {"Name", "RPYs", angles}}) {
      const std::vector<std::string> names = to_list(find(variables, list));
      const MatVariable* data = find(variables, field);
      if (names.empty() || data == nullptr || data->values.empty() || data->pages < 2) continue;
      if (data->height != names.size() || (data->width != 3 && data->width != 4)) continue;
      for (std::size_t marker = 0; marker < names.size(); ++marker) {
        for (std::size_t part = 0; part < parts.size() && made.columns.size() <= max_mat_columns; ++part) {
          const std::string name = names[marker] + parts[part];
          std::vector<double>& values = add_column(name, path_to(name), scope, true).values;
          for (std::size_t frame = 0; frame < data->pages; ++frame)
            values.push_back(data->values[(frame * data->width + part) * data->height + marker]);
        }
      }
      any = true;
    }
    return any;
  }

  /// Adds LabChart's data: all channels of all blocks in a row, with the start and end of each.
  bool add_labchart(Variables& variables) {
    const MatVariable* data = find(variables, "data");
    const MatVariable* begin = find(variables, "datastart");
    const MatVariable* end = find(variables, "dataend");
    if (data == nullptr || begin == nullptr || end == nullptr || data->values.empty()) return false;
    const std::size_t channels = begin->height, blocks = begin->width;
    if (begin->values.empty() || begin->values.size() != channels * blocks || end->values.size() != channels * blocks)
      refuse_labchart();
    const std::vector<std::string> titles = to_list(find(variables, "titles")),
                                   units = to_list(find(variables, "unittext"));
    const auto number_at = [&](const char* name, std::size_t at) -> std::optional<double> {
      const MatVariable* variable = find(variables, name);
      if (variable == nullptr || variable->values.size() != channels * blocks) return {};
      return variable->values[at];
    };
    std::size_t left = data->values.size();
    for (std::size_t at = 0; at < channels * blocks; ++at) {
      const double first = begin->values[at], last = end->values[at];
      if (first < 1.0 && last < 1.0) continue;  // -1: the block lacks this channel
      if (!(first >= 1.0 && last >= first && last <= static_cast<double>(data->values.size())) ||
          first != std::floor(first) || last != std::floor(last) || last - first + 1.0 > static_cast<double>(left))
        refuse_labchart();
      const std::size_t channel = at % channels, block = at / channels;
      std::string name = channel < titles.size() && !titles[channel].empty() ? titles[channel]
                                                                             : "channel " + std::to_string(channel + 1);
      const double unit = number_at("unittextmap", at).value_or(0.0);
      if (unit >= 1.0 && unit <= static_cast<double>(units.size()))
        name = labelled(name, units[static_cast<std::size_t>(unit) - 1]);
      MatScope scope;
      std::string path = name;
      if (blocks > 1) {
        scope.push_back("block" + std::to_string(block + 1));
        path = scope.back() + "." + name;
        elements_.emplace_back("block", block);
      }
      MatColumn& column = add_column(name, path, scope, true);
      if (blocks > 1) elements_.pop_back();
      const auto from = data->values.begin() + static_cast<std::ptrdiff_t>(first) - 1;
      column.values.assign(from, data->values.begin() + static_cast<std::ptrdiff_t>(last));
      left -= column.values.size();
      // 16-bit integers have a scale and an offset.
      const std::optional<double> scale = number_at("scaleunits", at), offset = number_at("scaleoffset", at);
      if (scale && offset)
        for (double& value : column.values) value = (value + *offset) * *scale;
      if (const std::optional<double> rate = number_at("samplerate", at))
        column.rate = StatedRate{*rate, "samplerate", true};
    }
    if (blocks > 1) made.arrays.push_back({"block", blocks});
    return true;
  }

  [[noreturn]] void refuse_labchart() const {
    throw Error(Code::file_damaged, where_, "comes from LabChart, and its datastart and dataend do not fit its data",
                "export it from LabChart again, or as text");
  }

  const std::string& where_;
  std::string outer_;                                          ///< path of the current structure
  std::vector<std::pair<std::string, std::size_t>> elements_;  ///< of the arrays around it
};

}  // namespace

MatColumns make_columns(std::vector<MatVariable> variables, const std::string& where) {
  Collector collector(where);
  collector.add_all(variables, {});
  return std::move(collector.made);
}

std::size_t shared_levels(const MatScope& a, const MatScope& b) {
  const auto [end, ignored] = std::ranges::mismatch(a, b);
  return static_cast<std::size_t>(end - a.begin());
}

}  // namespace decid::recording
