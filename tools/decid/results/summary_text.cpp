// The summary above the recordings of a call: see results.hpp.
#include <algorithm>
#include <map>
#include <set>

#include "base/text.hpp"
#include "tools/decid/results/group_results.hpp"
#include "tools/decid/results/results.hpp"

namespace decid::tools {
namespace {

/// Returns "4 recordings: 2 usable, 1 not usable, 1 not analysed"; empty for one recording.
std::string trusts_text(const std::vector<RecordingResult>& recordings) {
  if (recordings.size() < 2) return {};
  std::map<Trust, long long> analysed;
  long long failed = 0;
  for (const RecordingResult& id : recordings) ++(id.error ? failed : analysed[id.trust()]);
  std::string list;
  const auto add = [&](long long count, const std::string& what) {
    if (count > 0) list += format("%s%lld %s", list.empty() ? "" : ", ", count, what.c_str());
  };
  for (const auto& [trust, count] : analysed) add(count, name(trust));
  add(failed, "not analysed");
  return counted(std::ssize(recordings), "recording") + ": " + list + "\n";
}

/// Returns a line on recordings that were fitted together; empty if none was.
std::string joint_text(const std::vector<RecordingResult>& recordings) {
  std::set<std::vector<std::string>> groups;
  std::set<std::string> freed;
  long long count = 0;
  for (const RecordingResult& id : recordings) {
    if (!id.fit || !id.fit->joint) continue;
    ++count;
    groups.insert(id.fit->joint->files);
    freed.insert(id.fit->joint->freed.begin(), id.fit->joint->freed.end());
  }
  if (count == 0) return {};
  const std::string names = joined(freed, ", ");
  return "Fitted together: " + counted(count, "recording") + " in " + counted(std::ssize(groups), "group") +
         (names.empty() ? "" : "; parameters that differ between conditions: " + names) + "\n";
}

/// Returns a line on the controller with the largest log predictive density; empty without a comparison.
std::string controllers_line(const std::optional<ControllerSums>& sums) {
  if (!sums) return {};
  const auto best = std::ranges::find(sums->controllers, 0.0, &SummedController::difference);
  if (best == sums->controllers.end()) return {};
  std::string others;
  for (const SummedController& one : sums->controllers)
    if (one.difference < 0.0)
      others += format("%s%s %.1f +- %.1f nats below", others.empty() ? "; " : ", ", one.name.c_str(), -one.difference,
                       one.standard_error);
  return "Best controller over " + counted(static_cast<long long>(sums->recordings), "recording") + ": " + best->name +
         others + "\n";
}

}  // namespace

std::string summary_text(const Report& report) {
  return trusts_text(report.recordings) + joint_text(report.recordings) + verdicts_text(report) +
         controllers_line(sum_controllers(report));
}

}  // namespace decid::tools
