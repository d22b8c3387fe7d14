// The recordings of a plan that are fitted together: see joint_groups.hpp.
#include "identify/study/joint_groups.hpp"

#include <algorithm>
#include <functional>
#include <utility>

#include "base/error.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"
#include "identify/study/detail/text_key.hpp"

namespace decid {
namespace {

using TextOf = std::function<std::string(const SheetEntry& entry)>;

/// Returns the function that reads a column of the plan's sheet.
TextOf reader_for(const RecordingPlan& plan, const std::string& column) {
  if (plan.sheet) return plan.sheet->reader_for(column);
  throw Error(Code::setting_conflict, "joint posterior", "names the column '" + column + "', but the call has no sheet",
              "give the sheet, or fit all recordings of the call together with 'all'");
}

TextOf always(std::string text) {
  return [text = std::move(text)](const SheetEntry&) { return text; };
}

}  // namespace

void require_parameter(const std::string& name, const std::string& where, const sim::ParameterTable& table) {
  const std::vector<std::string> names = table.names();
  if (std::ranges::find(names, name) != names.end()) return;
  throw Error(Code::setting_unknown, where, "'" + name + "' is not a parameter", "name one of " + joined(names, ", "));
}

FreedParameters read_freed(const std::string& text, const sim::ParameterTable& table) {
  FreedParameters freed;
  if (text.empty()) return freed;
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == text.size())
    throw Error(Code::setting_malformed, setting("free"), "'" + text + "' is not NAME,..:COLUMN",
                "give parameters and a column of the sheet, such as theta,Nv:condition");
  freed.conditions = text.substr(colon + 1);
  for (std::size_t begin = 0; begin <= colon;) {
    const std::size_t end = std::min(text.find(',', begin), colon);
    require_parameter(freed.names.emplace_back(text.substr(begin, end - begin)), setting("free"), table);
    begin = end + 1;
  }
  return freed;
}

std::vector<FitGroup> joint_groups(const RecordingPlan& plan, const std::string& joint, const std::string& conditions) {
  const TextOf participant = !plan.sheet && joint == "all" ? always(joint) : reader_for(plan, joint),
               condition = conditions.empty() ? always({}) : reader_for(plan, conditions);
  std::vector<FitGroup> groups;
  std::vector<std::string> keys;
  for (std::size_t i = 0; i < plan.recordings.size(); ++i) {
    const PlannedRecording& planned = plan.recordings[i];
    const std::string key = text_key(participant(planned.entry));
    if (key.empty() || planned.error) continue;
    const auto found = std::ranges::find(keys, key);
    const auto place = static_cast<std::size_t>(found - keys.begin());
    if (found == keys.end()) {
      keys.push_back(key);
      groups.emplace_back();
    }
    groups[place].recordings.push_back(i);
    std::vector<std::string>& conditions_of = groups[place].conditions;
    const std::string here = condition(planned.entry);
    const auto same = std::ranges::find(conditions_of, text_key(here), text_key);
    conditions_of.push_back(same == conditions_of.end() ? here : std::string(*same));  // one spelling
  }
  std::erase_if(groups, [](const FitGroup& group) { return group.recordings.size() < 2; });
  return groups;
}

}  // namespace decid
