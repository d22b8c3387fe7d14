// The recordings of a plan that are fitted together: see joint_groups.hpp.
#include "identify/sheet/joint_groups.hpp"

#include <algorithm>
#include <functional>

#include "base/error.hpp"
#include "identify/sheet/text_key.hpp"

namespace decid {
namespace {

using TextOf = std::function<std::string(const SheetEntry& entry)>;

/// Returns the function that reads a column of the sheet.
TextOf reader_of(const RecordingPlan& plan, const std::string& column, const std::string& setting) {
  if (!plan.sheet)
    throw Error(Code::setting_conflict, setting, "names the column '" + column + "', but the call has no sheet",
                "give the sheet, or fit all recordings of the call together with 'all'");
  const std::string key = column_key(column);
  if (key == "participantid" || key == "participant") return [](const SheetEntry& entry) { return entry.participant; };
  if (key == "session") return [](const SheetEntry& entry) { return entry.session; };
  if (key == "group") return [](const SheetEntry& entry) { return entry.group; };
  if (key == "condition") return [](const SheetEntry& entry) { return entry.condition; };
  const std::vector<std::string>& columns = plan.sheet->columns;
  const auto found = std::ranges::find(columns, key, column_key);
  if (found == columns.end())
    throw Error(Code::column_missing, setting, "column '" + column + "' is not in " + plan.sheet->file.string(),
                "name participant_id, session, group, condition or another column of the sheet");
  const auto place = static_cast<std::size_t>(found - columns.begin());
  return [place](const SheetEntry& entry) { return place < entry.cells.size() ? entry.cells[place] : std::string(); };
}

}  // namespace

std::vector<FitGroup> joint_groups(const RecordingPlan& plan, const std::string& joint, const std::string& conditions) {
  const bool all = !plan.sheet && joint == "all";
  const TextOf person =
      all ? TextOf([](const SheetEntry&) { return std::string("all"); }) : reader_of(plan, joint, "joint posterior");
  const TextOf condition = conditions.empty() ? TextOf([](const SheetEntry&) { return std::string(); })
                                              : reader_of(plan, conditions, "joint posterior, conditions");
  std::vector<FitGroup> groups;
  std::vector<std::string> keys;
  for (std::size_t i = 0; i < plan.recordings.size(); ++i) {
    const PlannedRecording& planned = plan.recordings[i];
    const std::string key = text_key(person(planned.entry));
    if (key.empty() || planned.error) continue;
    const auto found = std::ranges::find(keys, key);
    const auto place = static_cast<std::size_t>(found - keys.begin());
    if (found == keys.end()) {
      keys.push_back(key);
      groups.emplace_back();
    }
    groups[place].recordings.push_back(i);
    groups[place].conditions.push_back(condition(planned.entry));
  }
  std::erase_if(groups, [](const FitGroup& group) { return group.recordings.size() < 2; });
  return groups;
}

}  // namespace decid
