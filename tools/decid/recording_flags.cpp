// The options of commands that read recordings: see recording_flags.hpp.
#include "tools/decid/recording_flags.hpp"

#include <algorithm>
#include <iostream>
#include <set>
#include <string_view>
#include <utility>

#include "base/error.hpp"
#include "base/number.hpp"
#include "base/text.hpp"
#include "identify/study/find_recordings.hpp"
#include "identify/study/reading_option.hpp"
#include "sim/segments.hpp"
#include "tools/decid/ranks.hpp"
#include "tools/decid/recording_files.hpp"

namespace decid::tools {
namespace {

/// Returns the units in which people give lengths in m by mistake. low, high: of a person, in m.
OtherUnits other_lengths(double low, double high) {
  return {.low = low, .high = high, .sizes = {{"cm", 0.01}, {"inches", 0.0254}, {"mm", 0.001}}};
}

/// An error of recordings, and the lines of the sheet that have it.
struct ErrorLine {
  std::string before, after;  ///< the text before and after ", line 3"
  std::set<std::size_t> numbers = {};
  long long count = 0;  ///< of recordings

  explicit ErrorLine(const std::string& text) : before(text) {
    constexpr std::string_view mark = ", line ";
    const std::size_t at = text.find(mark), digits = at + mark.size();
    if (at == text.npos) return;
    const std::size_t end = std::min(text.find_first_not_of("0123456789", digits), text.size());
    const std::optional<std::size_t> number = number_from<std::size_t>(text.substr(digits, end - digits));
    if (!number) return;
    numbers.insert(*number);
    before = text.substr(0, at);
    after = text.substr(end);
  }
  std::string text() const {
    constexpr std::size_t max_shown = 10;
    std::string list;
    std::size_t shown = 0;
    for (const std::size_t number : numbers)
      if (shown++ < max_shown) list += (list.empty() ? "" : ", ") + std::to_string(number);
    if (numbers.size() > max_shown) list += format(" and %zu others", numbers.size() - max_shown);
    return before + (list.empty() ? "" : (numbers.size() > 1 ? ", lines " : ", line ") + list) + after;
  }
};

/// The value of --tilt-column and --trial for none.
constexpr const char* no_column = "none";

}  // namespace

ReadOptions RecordingFlags::read_options() const {
  ReadOptions made;
  made.recording.column = column;
  made.recording.unit = angle_unit_named(unit);
  made.recording.rate_hz = rate;
  made.recording.fill_gaps_s = fill_gaps;
  made.recording.missing_value = missing;
  made.recording.metres_per_unit = metres_of_unit(unit);
  made.recording.skip_lines = skip_lines;
  made.recording.section = section;
  made.recording.com_height_m = com_height;
  made.recording.is_one_trial = trial == no_column;
  if (!made.recording.is_one_trial) made.recording.trial_column = trial;
  made.recording.leg_column = leg;
  made.recording.trunk_column = trunk;
  made.recording.hip_column = hip;
  made.recording.shoulder_column = shoulder;
  made.recording.ankle_column = ankle;
  made.recording.body_height_m = height_m;
  made.recording.find_tilt = tilt_column != no_column;
  if (made.recording.find_tilt) made.recording.tilt_column = tilt_column;
  made.recording.tilt_unit = angle_unit_named(tilt_unit);
  made.recording.invert_sway = invert == "sway" || invert == "both";
  made.recording.invert_tilt = invert == "tilt" || invert == "both";
  made.trial.start_s = begin;
  if (detrend == "offset") made.trial.detrend = recording::Detrend::offset;
  if (detrend == "linear") made.trial.detrend = recording::Detrend::linear;
  const bool names_tilt = !made.recording.tilt_column.empty();
  if (!made.recording.find_tilt && (!tilt_unit.empty() || made.recording.invert_tilt)) {
    throw Error(Code::setting_missing, "--tilt-unit, --invert", "no tilt is read",
                "name its column with --tilt-column");
  }
  if (skip_lines && !section.empty())
    throw Error(Code::setting_conflict, "--section, --skip-lines", "both say where the table begins",
                "give one of the two");
  if (begin && names_tilt) {
    throw Error(Code::setting_conflict, "--begin", "--tilt-column already says where the protocol starts",
                "give one of the two");
  }
  return made;
}

void RecordingFlags::find_sources(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs,
                                  bool quiet) {
  std::vector<std::string> others = inputs;
  std::ranges::copy_if(outputs, std::back_inserter(others),
                       [](const std::string& output) { return !has_ending_of_recordings(output); });
  if (!study.empty() && files.empty()) {
    try {
      const std::string folder = std::filesystem::path(study).parent_path().string();
      files = recording_files({folder.empty() ? "." : folder}, others, true).files;
      for (std::string& file : files) file = std::filesystem::path(file).lexically_normal().string();  // no "./"
    } catch (const Error&) {
      files.clear();  // each line's recording is missing
    }
    sources = make_sources({files.begin(), files.end()}, read_options().recording);
    return;
  }
  const RecordingFiles found = recording_files(files, others, recursive);
  if (const std::string text = found.left_out.text(); !quiet && !text.empty()) std::cerr << "note: " << text << '\n';
  sources = make_sources({found.files.begin(), found.files.end()}, read_options().recording);
  files.clear();
  for (const RecordingSource& source : sources) files.push_back(source.name());
  named = distinct_files();
}

RecordingPlan RecordingFlags::plan(const ReadOptions& reading, bool quiet) {
  if (study.empty()) return make_plan(sources, reading);
  RecordingPlan made =
      make_plan(read_sheet(study), sources, named.empty() ? Choice::by_sheet : Choice::by_call, reading);
  sources.clear();
  files.clear();
  for (const PlannedRecording& recording : made.recordings) {
    sources.push_back(recording.source);
    files.push_back(recording.source.name());
  }
  if (!quiet && is_root())
    for (const std::string& note : made.notes) std::cerr << "note: " << one_line(note) << '\n';
  return made;
}

std::vector<std::string> RecordingFlags::distinct_files() const {
  std::vector<std::string> distinct;
  for (const RecordingSource& source : sources)
    if (distinct.empty() || distinct.back() != source.file) distinct.push_back(source.file.string());
  return distinct;
}

std::optional<sim::Body> BodyFlags::body() const {
  if (mass_kg.has_value() != height_m.has_value())
    throw Error(Code::setting_missing, "--mass, --height", "one is given without the other",
                "give both, or neither for the protocol's body");
  if (!mass_kg) return {};
  return sim::body_of_participant({.mass_kg = *mass_kg, .height_m = *height_m});
}

void BodyFlags::refuse_instead_of(const sim::Protocol& protocol) const {
  if (const std::optional<sim::Body> person = body()) sim::refuse_person(*person, protocol, "--mass, --height");
}

std::optional<sim::Parameters> RecordingFlags::known(const sim::ParameterTable& table) const {
  if (truth.empty()) return {};
  return table.from_text(truth, "--truth");
}

Option add_recording_flags(const Command& command, RecordingFlags& flags) {
  command.section("Input");
  Option recordings = command.add_option("recordings", flags.files,
                                         "Read these recordings: CSV, MAT, C3D or .xlsx files, folders of them, "
                                         "or quoted patterns; - reads standard input");
  recordings.unrecorded();  // the call's record has the files that they lead to
  command.add_flag("--recursive", flags.recursive, "Also read the folders inside folders").unrecorded();
  add_reading_options(command, flags);
  return recordings;
}

void add_reading_options(const Command& command, RecordingFlags& flags) {
  command.section("Input");
  command.add_option("--column", flags.column,
                     "Read sway from this column, by name or number from 1; default: found by its name");
  command
      .add_option("--unit", flags.unit,
                  "Read sway in this unit: deg, rad, mrad, or mm, cm, m for positions; default: from the column's "
                  "name, else deg")
      .one_of({"deg", "rad", "mrad", "mm", "cm", "m"});
  command
      .add_option("--com-height", flags.com_height,
                  "Treat the sway column as the forward position of a marker this many m above the ankle")
      .range(0.01, 3.0, "m", other_lengths(0.5, 1.5));
  command.add_option(
      "--leg", flags.leg,
      "Read the leg's angle in space from this column, by name or number; give --trunk too, instead of sway");
  command.add_option("--trunk", flags.trunk, "Read the trunk's angle in space from this column; give --leg too");
  command.add_option(
      "--hip", flags.hip,
      "Read the hip's forward position from this column; give --shoulder, --mass and --height too, instead of sway");
  command.add_option("--shoulder", flags.shoulder,
                     "Read the shoulder's forward position from this column; give --hip too");
  command.add_option("--ankle", flags.ankle,
                     "Subtract the ankle's position in this column; default: the mean positions are upright");
  command
      .add_option("--skip-lines", flags.skip_lines,
                  "Skip this many lines above the table of a text file; default: decid finds the table")
      .range(0, 1000000);
  command.add_option(
      "--section", flags.section,
      "Read this table of a text file that holds several, by name or number from 1, for example Trajectories, or this "
      "sheet of a workbook, by name");
  command.add_option("--trial", flags.trial,
                     "Split a file into recordings by the values of this column, of several columns (subject,trial), "
                     "or by this MAT array; none: one recording per file; default: refuse files with several trials");
  command.add_option("--rate", flags.rate, "Use this sample rate in Hz; default: from the time column")
      .range(1.0, 100000.0);
  command
      .add_option("--fill-gaps", flags.fill_gaps, "Interpolate gaps of up to this many seconds; default: refuse gaps")
      .range(0.0, recording::longest_gap_s);
  command.add_option("--missing", flags.missing,
                     "Read this number as a missing value; default: 9999, -9.99e33 and similar numbers that are far "
                     "outside the signal");
  command
      .add_option("--begin,--start", flags.begin,
                  "Start the protocol this many seconds after the first sample; default: found in the tilt, else 0")
      .range(0.0, 1e6);
  command.add_option("--tilt-column", flags.tilt_column,
                     "Read the measured tilt from this column, by name or number, to find the protocol's start; none: "
                     "read no tilt; default: a column named tilt, platform or similar");
  command
      .add_option(
          "--tilt-unit", flags.tilt_unit,
          "Read tilt in this unit: deg, rad or mrad; default: from the column's name, else an angle's --unit, else deg")
      .one_of({"deg", "rad", "mrad"});
  command.add_option("--invert", flags.invert, "Reverse the sign of sway, tilt or both")
      .one_of({"sway", "tilt", "both"});
  command
      .add_option("--detrend", flags.detrend,
                  "Subtract the mean of whole cycles (offset) or a straight line (linear) from sway; default: none")
      .one_of({"none", "offset", "linear"});
}

void add_body_options(const Command& command, BodyFlags& flags) {
  command.section("Person");
  command
      .add_option("--mass", flags.mass_kg, "Set the person's mass in kg, with --height; default: the protocol's body")
      .range(1.0, 250.0, "", {.low = 30.0, .high = 250.0, .sizes = {{"lb", 0.45359237}, {"g", 0.001}}});
  command.add_option("--height", flags.height_m, "Set the person's height in m, with --mass")
      .range(0.3, 3.0, "m", other_lengths(1.0, 2.5));
}

void add_study_option(const Command& command, RecordingFlags& flags) {
  command.section("Input");
  command.add_option(
      "--study", flags.study,
      "Read participants, groups, bodies, protocols and reading options from this sheet (TSV, CSV or .xlsx) with one "
      "line per recording or participant; if you name no recordings, read those of the sheet");
}

void add_truth_option(const Command& command, RecordingFlags& flags) {
  command.section("Output");
  command.add_option(
      "--truth", flags.truth,
      "Show these known parameters beside the estimates: Kp=..,Kd=..,Kp_pass=..,Kd_pass=..,Nv=..,theta=..,delay=..");
}

void tell_errors(const std::string& command, const std::vector<RecordingResult>& all) {
  std::vector<ErrorLine> lines;  // each once: a person's line may fail for all recordings, and a column in all lines
  for (const RecordingResult& id : all) {
    if (!id.error) continue;
    const ErrorLine here(one_line(id.error->what()));
    const auto same = std::ranges::find_if(
        lines, [&](const ErrorLine& one) { return one.before == here.before && one.after == here.after; });
    ErrorLine& line = same == lines.end() ? lines.emplace_back(here) : *same;
    line.numbers.insert(here.numbers.begin(), here.numbers.end());
    ++line.count;
  }
  for (const ErrorLine& line : lines)
    std::cerr << "decid: " << line.text() << (line.count > 1 ? " (" + counted(line.count, "recording") + ")" : "")
              << '\n';
  const auto failed = std::ranges::count_if(all, [](const RecordingResult& id) { return id.error.has_value(); });
  if (failed > 0) {
    throw Error(Code::recordings_failed, command,
                std::to_string(failed) + " of " + std::to_string(all.size()) + " recordings failed",
                std::string("see the lines above, or \"error\" in the JSON") +
                    (failed < std::ssize(all) ? "; the others are done" : ""));
  }
}

}  // namespace decid::tools
