// The recordings of a call: see recording_plan.hpp.
#include "identify/study/recording_plan.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <map>
#include <system_error>
#include <tuple>
#include <utility>

#include "base/text.hpp"
#include "identify/study/detail/contradictions.hpp"
#include "identify/study/detail/path_match.hpp"
#include "identify/study/detail/person_lines.hpp"
#include "identify/study/reading_option.hpp"
#include "sim/segments.hpp"

namespace decid {
namespace {

using Likeness = PathKey::Likeness;
using ReadingOptions = std::vector<std::pair<std::string, std::string>>;

/// Returns the options of the sheet that say which part of a file is the recording.
ReadingOptions part_options(const PlannedRecording& planned) {
  constexpr std::array names{"section",      "column",     "begin",          "leg_column",
                             "trunk_column", "hip_column", "shoulder_column"};
  ReadingOptions found = planned.options;
  std::erase_if(found, [&](const auto& option) { return std::ranges::find(names, option.first) == names.end(); });
  return found;
}

/// Gives recordings of one name labels, by the options in which they differ.
void label_parts(std::vector<PlannedRecording>& recordings) {
  std::map<std::string, std::vector<std::size_t>> of_name;
  for (std::size_t i = 0; i < recordings.size(); ++i)
    if (!recordings[i].error) of_name[recordings[i].source.name()].push_back(i);
  for (const auto& named : of_name) {
    const std::vector<std::size_t>& some = named.second;
    std::map<std::pair<std::string, std::string>, std::size_t> count;
    for (const std::size_t i : some)
      for (const auto& option : part_options(recordings[i])) ++count[option];
    for (const std::size_t i : some) {
      ReadingOptions own = part_options(recordings[i]);
      std::erase_if(own, [&](const auto& option) { return count[option] == some.size(); });
      recordings[i].source.label = joined(own, " ", [](const auto& option) { return option.second; });
    }
  }
}

/// Returns the path of a sheet's cell: relative to the sheet's folder, with slashes.
std::filesystem::path path_beside(const StudySheet& sheet, std::string cell) {
  std::ranges::replace(cell, '\\', '/');
  return sheet.file.parent_path() / cell;
}

class Planner {
 public:
  Planner(StudySheet sheet, const std::vector<RecordingSource>& sources, Choice choice, const ReadOptions& reading)
      : sources_(sources), choice_(choice), reading_(reading) {
    plan_.notes = sheet.notes;
    plan_.sheet = std::move(sheet);
    names_sessions_ = std::ranges::any_of(lines(), [](const SheetLine& line) { return !line.entry.session.empty(); });
    for (SheetLine& line : plan_.sheet->lines)  // before bodies are taken from lines of the same session
      if (!line.file.empty()) set_session(line, path_beside(*plan_.sheet, line.file));
    people_ = PersonLines(lines());
    bodies_ = PersonBodies(lines());
    for (const SheetLine& line : lines()) line_keys_.emplace_back(line.file);
    for (const RecordingSource& source : sources) {
      const PathKey& key = source_keys_.emplace_back(shown(source));
      path_keys_.push_back(choice == Choice::for_groups ? PathKey(std::filesystem::absolute(source.name()).string())
                                                        : key);
      name_keys_.emplace_back(source.name());
      file_keys_.emplace_back(source.file.string());
    }
    used_.assign(lines().size(), false);
    names_people_ = choice != Choice::for_groups &&
                    std::ranges::any_of(lines(), [](const SheetLine& line) { return !line.entry.participant.empty(); });
  }

  RecordingPlan operator()() {
    if (choice_ == Choice::by_sheet)
      plan_sheet();
    else
      plan_call();
    label_parts(plan_.recordings);
    return std::move(plan_);
  }

 private:
  const std::vector<SheetLine>& lines() const { return plan_.sheet->lines; }

  /// Returns the path that names of people are searched in: the part below the sheet's folder, if it lies there.
  std::string shown(const RecordingSource& source) const {
    std::error_code error, other;  // of the current folder, which may be gone
    const std::filesystem::path
        folder = std::filesystem::absolute(plan_.sheet->file, error).parent_path().lexically_normal(),
        below = std::filesystem::absolute(source.name(), other).lexically_normal().lexically_relative(folder);
    if (error || other) return source.name();
    return below.empty() || *below.begin() == ".." ? source.name() : below.string();
  }

  void plan_call() {
    for (std::size_t i = 0; i < sources_.size(); ++i) plan_source(i);
    for (std::size_t line = 0; line < lines().size(); ++line) {
      if (used_[line]) continue;
      const SheetLine& unused = lines()[line];
      if (choice_ == Choice::for_groups)
        plan_.unused.push_back(line);
      else if (unused.error && unused.file.empty() && unused.entry.participant.empty())
        plan_.notes.emplace_back(unused.error->what());
      else if (unused.file.empty() || is_near(line))
        plan_.notes.push_back(plan_.sheet->locate(unused) + ": no recording of this call is of " +
                              (unused.file.empty() ? unused.entry.participant : unused.file));
      else
        add_missing(line, "names " + unused.file + ", which does not exist");
    }
  }

  /// Returns true if a file below the sheet's folder is the line's.
  bool is_near(std::size_t line) {
    namespace fs = std::filesystem;
    std::error_code error;
    if (fs::exists(path_beside(*plan_.sheet, lines()[line].file), error)) return true;
    if (!near_) {
      near_.emplace();
      const fs::path folder = plan_.sheet->file.parent_path();
      fs::recursive_directory_iterator at(folder.empty() ? "." : folder, fs::directory_options::skip_permission_denied,
                                          error);
      for (; !error && at != fs::end(at); at.increment(error))
        if (std::error_code ignored; at->is_regular_file(ignored)) near_->emplace_back(at->path().string());
    }
    return std::ranges::any_of(*near_,
                               [&](const PathKey& path) { return path.ends_with(line_keys_[line]) != Likeness::none; });
  }

  /// Adds a recording of the call with the lines that are of it.
  void plan_source(std::size_t i) {
    std::vector<std::size_t> best;
    std::pair best_rank(std::size_t{0},
                        Likeness::none);  // a line with folders is surer than one in the same letter case
    for (std::size_t line = 0; line < lines().size(); ++line) {
      if (lines()[line].file.empty()) continue;
      const std::pair rank(line_keys_[line].parts(), likeness_of(i, line));
      if (rank.second == Likeness::none || rank < best_rank) continue;
      if (rank > best_rank) best.clear();
      best_rank = rank;
      best.push_back(line);
    }
    for (const std::size_t line : best) used_[line] = true;
    if (best.size() > 1)
      return add(sources_[i], lines()[best[0]],
                 Error(Code::value_invalid, sources_[i].name(),
                       "is the file of " + plan_.sheet->locate(lines()[best[0]]) + " and of line " +
                           std::to_string(lines()[best[1]].number),
                       "keep one line, or put folders before the names"));
    if (!best.empty()) return add(sources_[i], with_person(best[0]));
    const FittingLines found = people_.find(source_keys_[i]);
    for (const std::size_t line : found.fitting) used_[line] = true;
    if (found.line) return add(sources_[i], lines()[*found.line]);
    if (!found.fitting.empty()) return add_unclear(i, found.fitting[0], found.fitting[1]);
    const std::string sheet = plan_.sheet->file.string();
    if (found.elsewhere.empty())
      return add(sources_[i], SheetLine{},
                 Error(Code::value_missing, sources_[i].name(), "has no line in " + sheet,
                       "add a line with its file or its participant_id"));
    const SheetEntry& person = lines()[found.elsewhere.front()].entry;
    add(sources_[i], SheetLine{},
        Error(
            Code::value_missing, sources_[i].name(),
            "has no line of its session in " + sheet + ": " + person.participant + " has " + sessions(found.elsewhere),
            "correct the session of the line, or of the file's name or folder"));
  }

  /// Returns "session pre" or "sessions pre and post" of the lines.
  std::string sessions(const std::vector<std::size_t>& some) const {
    std::vector<std::string> names;
    for (const std::size_t line : some)
      if (std::ranges::find(names, lines()[line].entry.session) == names.end())
        names.push_back(lines()[line].entry.session);
    return (names.size() == 1 ? "session " : "sessions ") + joined(names, " and ");
  }

  /// Returns the likeness of a recording and a line's file; "long.csv" is also the file of "long.csv#2".
  Likeness likeness_of(std::size_t source, std::size_t line) const {
    const Likeness whole = path_keys_[source].ends_with(line_keys_[line]);
    if (whole != Likeness::none || sources_[source].trial.empty()) return whole;
    return file_keys_[source].ends_with(line_keys_[line]);
  }

  /// Adds a recording whose path fits two people, or two sessions of a person, equally well.
  void add_unclear(std::size_t source, std::size_t one, std::size_t other) {
    const auto shown = [&](std::size_t line) {
      const SheetEntry& entry = lines()[line].entry;
      return " (" + entry.participant + (entry.session.empty() ? "" : ", session " + entry.session) + ")";
    };
    add(sources_[source], SheetLine{},
        Error(Code::value_invalid, sources_[source].name(),
              "has a path that fits " + plan_.sheet->locate(lines()[one]) + shown(one) + " and line " +
                  std::to_string(lines()[other].number) + shown(other),
              "name its line in a column \"file\", or name folders by participant_id: sub-ID, and ses-ID by session"));
  }

  /// Fills a recording's line from the lines of its person, if the sheet has some.
  SheetLine with_person(std::size_t recording) {
    SheetLine line = lines()[recording];
    for (std::size_t i = 0; i < lines().size(); ++i) {
      if (!people_.covers(i, recording)) continue;
      used_[i] = true;
      line = merged(std::move(line), lines()[i]);
    }
    return line;
  }

  void plan_sheet() {
    std::vector<std::vector<std::size_t>> found(lines().size());  // recordings of each line with a file
    std::vector<bool> taken(sources_.size(), false);
    for (std::size_t line = 0; line < lines().size(); ++line) {
      if (!lines()[line].file.empty()) found[line] = find(line);
      if (found[line].size() == 1) taken[found[line][0]] = true;
    }
    std::vector<FittingLines> of_people(sources_.size());
    for (std::size_t i = 0; i < sources_.size(); ++i)
      if (!taken[i]) of_people[i] = people_.find(source_keys_[i]);
    for (std::size_t line = 0; line < lines().size(); ++line) {
      if (!lines()[line].file.empty())
        plan_line(line, found[line]);
      else
        plan_person(line, of_people);
    }
  }

  /// Returns the most alike among the files near the sheet.
  std::vector<std::size_t> find(std::size_t line) const {
    std::vector<std::size_t> best;
    Likeness likeness = Likeness::none;
    const PathKey direct(path_beside(*plan_.sheet, lines()[line].file).string());
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      const Likeness here = likeness_of(i, line);
      const PathKey& name = name_keys_[i];
      if (name.parts() == direct.parts() && name.ends_with(direct) == Likeness::exact) return {i};
      if (here == Likeness::none || here < likeness) continue;
      if (here > likeness) best.clear();
      likeness = here;
      best.push_back(i);
    }
    return best;
  }

  void plan_line(std::size_t line, const std::vector<std::size_t>& best) {
    const SheetLine here = with_person(line);
    std::error_code ignored;
    const std::filesystem::path direct = path_beside(*plan_.sheet, here.file);
    if (best.size() > 1 && sources_[best[0]].trial.empty())
      return add(
          direct, here,
          Error(Code::value_invalid, plan_.sheet->locate(here),
                "names " + here.file + ", which may be " + sources_[best[0]].name() + " or " + sources_[best[1]].name(),
                "put the folder before the file's name"));
    for (const std::size_t i : best) {
      add(sources_[i], here);
      std::optional<Error>& error = plan_.recordings.back().error;
      if (!error) error = repeated(sources_[i], here);
    }
    if (!best.empty()) return;
    if (std::filesystem::is_regular_file(direct, ignored)) return add(direct, here);
    add_missing(line, "names " + here.file + ", which does not exist");
  }

  /// Returns an error if a line before names the same recording with the same protocol and options of reading.
  std::optional<Error> repeated(const RecordingSource& source, const SheetLine& line) {
    const auto [first, is_new] = named_.try_emplace({source.name(), line.protocol, line.reading}, line.number);
    if (is_new) return std::nullopt;
    return Error(Code::value_invalid, plan_.sheet->locate(line),
                 "names " + source.name() + ", as line " + std::to_string(first->second) + " does",
                 "delete one of them");
  }

  void plan_person(std::size_t line, const std::vector<FittingLines>& of_people) {
    const SheetLine& person = lines()[line];
    bool has_one = people_.has_recording_line(line);
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      const FittingLines& found = of_people[i];
      const bool is_unclear = !found.line && std::ranges::find(found.fitting, line) != found.fitting.end();
      if (!is_unclear && found.line != line) continue;
      has_one = true;
      if (!is_unclear)
        add(sources_[i], person);
      else if (line == found.fitting[0])
        add_unclear(i, found.fitting[0], found.fitting[1]);
    }
    if (has_one) return;  // its recordings have the error of the line
    const std::string name = person.entry.participant.empty() ? plan_.sheet->locate(person) : person.entry.participant;
    add(std::filesystem::path(name), person,
        person.error
            ? *person.error
            : Error(Code::file_missing, plan_.sheet->locate(person),
                    "no recording below its folder is of " + name +
                        (person.entry.session.empty() ? "" : " in session " + person.entry.session),
                    std::string("put the participant_id") + (person.entry.session.empty() ? "" : " and the session") +
                        " into the names of files or folders, or add a column \"file\""));
  }

  void add_missing(std::size_t line, const std::string& problem) {
    add(path_beside(*plan_.sheet, lines()[line].file), with_person(line),
        Error(Code::file_missing, plan_.sheet->locate(lines()[line]), problem,
              "correct the name, or copy the file there"));
  }

  /// Sets the session of a line that has none from its recording's path, if no line of the sheet names a session. A
  /// path with two is an error of the line.
  void set_session(SheetLine& line, const std::filesystem::path& path) const {
    if (names_sessions_ || !line.entry.session.empty() || line.error) return;
    const std::vector<std::string> labels = PathKey(std::filesystem::absolute(path).string()).session_labels();
    if (labels.size() > 1)
      line.error = Error(Code::value_invalid, path.string(),
                         "names two sessions, " + labels[0] + " and " + labels[1] + ", in its path",
                         "rename it, or give a column \"session\"");
    else if (!labels.empty())
      line.entry.session = labels.front();
  }

  void add(const RecordingSource& source, SheetLine line, const std::optional<Error>& error = {}) {
    set_session(line, source.file);
    Warnings of_body = error || line.error ? Warnings() : bodies_.fill(line);
    PlannedRecording planned{source, reading_, 0, line.entry, line.mass_kg, line.height_m};
    planned.is_body_of_other_line = !of_body.empty();
    planned.warnings = std::move(of_body);
    planned.options = line.reading;
    if (line.number > 0) planned.line = plan_.sheet->locate(line);
    planned.entry.cells.resize(plan_.sheet->columns.size());
    planned.error = error ? error : line.error;
    if (names_people_ && line.number > 0 && !line.file.empty() && line.entry.participant.empty()) {
      plan_.nameless.push_back(line.number);
      if (!planned.error)
        planned.error =
            Error(Code::value_missing, plan_.sheet->locate(line),
                  "has no " + plan_.sheet->participant_column + ", and other lines have one", repeat_the_name);
    }
    RecordingSetting setting{reading_.body, {}};
    try {
      apply(line, planned.reading, setting);
    } catch (const Error& wrong) {
      if (!planned.error)
        planned.error = Error(wrong.code(), plan_.sheet->locate(line), wrong.problem(), wrong.remedy());
    }
    planned.reading.body = setting.body;
    auto found = std::ranges::find(plan_.settings, setting);
    if (found == plan_.settings.end()) found = plan_.settings.insert(found, setting);
    planned.setting = static_cast<std::size_t>(found - plan_.settings.begin());
    plan_.recordings.push_back(std::move(planned));
  }

  void apply(const SheetLine& line, ReadOptions& reading, RecordingSetting& setting) const {
    const std::string where = plan_.sheet->locate(line);
    for (const auto& [name, value] : line.reading) set_reading_option(reading, name, value, where);
    if (line.height_m) reading.recording.body_height_m = line.height_m;
    if (line.mass_kg.has_value() != line.height_m.has_value())
      throw Error(Code::value_missing, where,
                  line.mass_kg ? "gives a weight and no height" : "gives a height and no weight",
                  "give both, or neither for the assumed body");
    if (line.mass_kg) setting.body = sim::body_of_participant({.mass_kg = *line.mass_kg, .height_m = *line.height_m});
    if (line.protocol.empty()) return;
    std::error_code ignored;
    const std::filesystem::path file = path_beside(*plan_.sheet, line.protocol);
    setting.protocol = std::filesystem::is_regular_file(file, ignored) ? file.string() : line.protocol;
  }

  const std::vector<RecordingSource>& sources_;
  Choice choice_;
  const ReadOptions& reading_;
  RecordingPlan plan_;
  std::vector<PathKey> line_keys_;
  std::vector<PathKey> source_keys_, path_keys_;  // of sources: what people, and what lines' files, are searched in
  std::vector<PathKey> name_keys_, file_keys_;    // their names, and their files
  PersonLines people_;
  PersonBodies bodies_;
  bool names_people_ = false;                 // some line does, and people count
  bool names_sessions_ = false;               // some line does
  std::optional<std::vector<PathKey>> near_;  // files below the sheet's folder, once they are needed
  std::vector<bool> used_;                    // lines
  /// Numbers of the lines that name recordings: of a recording, a protocol and options of reading.
  std::map<std::tuple<std::string, std::string, ReadingOptions>, std::size_t> named_;
};

}  // namespace

RecordingPlan make_plan(const std::vector<RecordingSource>& sources, const ReadOptions& reading) {
  RecordingPlan plan{{{reading.body, {}}}, {}};
  for (const RecordingSource& source : sources) plan.recordings.push_back({source, reading});
  warn_of_copies(plan);
  return plan;
}

RecordingPlan make_plan(StudySheet sheet, const std::vector<RecordingSource>& sources, Choice choice,
                        const ReadOptions& reading) {
  refuse_two_spellings(sheet);
  if (choice == Choice::for_groups) return Planner(std::move(sheet), sources, choice, reading)();
  refuse_two_groups(sheet);
  std::vector<RecordingSource> others;  // all but the sheet, which may lie among its recordings
  std::ranges::copy_if(sources, std::back_inserter(others), [&](const RecordingSource& source) {
    std::error_code ignored;
    return source.file.filename() != sheet.file.filename() ||
           !std::filesystem::equivalent(source.file, sheet.file, ignored);
  });
  RecordingPlan plan = Planner(std::move(sheet), others, choice, reading)();
  warn_of_contradictions(plan);
  warn_of_copies(plan);
  return plan;
}

void refuse_repeated(const RecordingPlan& plan, const std::string& option) {
  std::map<std::tuple<std::filesystem::path, std::string, ReadingOptions>, std::string> names;
  for (const PlannedRecording& planned : plan.recordings) {
    if (planned.error) continue;
    const RecordingSource& source = planned.source;
    std::error_code failed;
    const std::filesystem::path place = std::filesystem::canonical(source.file, failed);
    const auto [first, is_new] =
        names.try_emplace({failed ? source.file : place, source.trial, part_options(planned)}, source.name());
    if (is_new) continue;
    const std::string& other = first->second;
    throw Error(Code::setting_conflict, source.name(),
                other == source.name() ? "is given twice" : "is the same recording as " + other,
                "give each recording of " + option + " once");
  }
}

}  // namespace decid
