// Fits of all recordings, in groups of one or of several that are fitted together: see fit_recordings.hpp.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <deque>
#include <mutex>
#include <utility>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "identify/detail/fit_warnings.hpp"
#include "identify/detail/fitter.hpp"
#include "identify/fit_recordings.hpp"

namespace decid {
namespace {

/// Returns the number of the common unknown that each parameter is in each recording: see posterior::TargetTrial. A
/// freed parameter is another unknown in each condition.
std::vector<std::vector<std::size_t>> common_unknowns(const std::vector<std::string>& names,
                                                      const std::vector<std::string>& freed,
                                                      std::span<const std::string> conditions) {
  std::vector<std::vector<std::size_t>> common(conditions.size());
  std::size_t count = 0;
  for (const std::string& name : names) {
    const bool is_freed = std::ranges::find(freed, name) != freed.end();
    std::vector<std::string> known;  // conditions with an unknown of their own
    for (std::size_t i = 0; i < conditions.size(); ++i) {
      const std::string condition = is_freed ? conditions[i] : std::string();
      const auto found = std::ranges::find(known, condition);
      common[i].push_back(count + static_cast<std::size_t>(found - known.begin()));
      if (found == known.end()) known.push_back(condition);
    }
    count += known.size();
  }
  return common;
}

}  // namespace

/// Returns true if the recording is not for the others' fit, because it would bias what they tell; `one` then has a fit
/// of its own. A recording that hardly follows the tilt, perhaps of another stimulus, is fitted alone to decide that.
bool Fitter::is_left_out(RecordingResult& one, const posterior::OnProgress& progress) {
  const bool is_known = !reason_to_leave_out(one).empty();
  if (!is_known && !may_not_follow_tilt(one.trial)) return false;
  RecordingResult alone = one;
  fit(alone, prepare(alone), progress);
  if (!is_known && reason_to_leave_out(alone).empty()) return false;
  one = std::move(alone);
  return true;
}

struct Fitter::Member {
  Fitter* fitter;
  RecordingResult* result;
  std::string condition;
  Prepared prepared;
};

void Fitter::fit_together(std::span<RecordingResult> read, const FitterOf& fitter_of, const FitGroup& group,
                          const posterior::OnProgress& progress) {
  std::deque<Member> members;
  for (std::size_t i = 0; i < group.recordings.size(); ++i) {
    const std::size_t place = group.recordings[i];
    RecordingResult& one = read[place];
    if (one.error) continue;
    attempt(one, [&] {  // the others are fitted without a recording that has an error
      Fitter& fitter = fitter_of(place);
      if (fitter.is_left_out(one, progress)) return;
      members.push_back(
          {&fitter, &one, group.conditions.empty() ? std::string() : group.conditions[i], fitter.prepare(one)});
    });
  }
  if (members.empty()) return;
  if (members.size() == 1) {
    const Member& only = members.front();
    return attempt(*only.result, [&] { only.fitter->fit(*only.result, only.prepared, progress); });
  }
  try {
    fit_jointly(members, progress);
  } catch (const Error& error) {
    for (const Member& member : members)
      if (!member.result->error) member.result->error = in_file(error, member.result->file);
  }
}

void Fitter::fit_jointly(std::deque<Member>& members, const posterior::OnProgress& progress) {
  const auto begin = std::chrono::steady_clock::now();
  const FitRequest& request = *members.front().fitter->report_.fit;
  if (!request.others.empty())
    throw Error(Code::setting_conflict, "joint posterior", "is for one controller, not for a comparison of several",
                "fit the controllers in calls of their own");
  const sim::ParameterTable& table = members.front().prepared.density->ranges();
  for (const std::string& name : request.freed)
    if (std::ranges::find(table, name, &sim::ParameterInfo::name) == table.end())
      throw Error(Code::setting_unknown, "joint posterior", "parameter '" + name + "' is not one of the controller's",
                  "name another");
  JointFit joint{{}, request.freed, {}};
  std::vector<std::string> conditions;
  for (const Member& member : members) {
    joint.files.push_back(member.result->file);
    conditions.push_back(member.condition);
  }
  const std::vector<std::vector<std::size_t>> common = common_unknowns(table.names(), request.freed, conditions);
  std::vector<posterior::TargetTrial> trials;
  for (std::size_t i = 0; i < members.size(); ++i)
    trials.push_back({members[i].prepared.density, &members[i].prepared.observation, common[i]});
  bool cut = false;
  std::vector<posterior::Posterior> found =
      posterior::sample_joint(posterior::Target(std::move(trials)), request.settings, noting_stop(progress, cut));
  for (std::size_t i = 0; i < members.size(); ++i) {
    RecordingResult& result = *members[i].result;
    attempt(result, [&] { members[i].fitter->conclude(result, members[i].prepared, std::move(found[i])); });
    if (result.error) continue;
    joint.condition = members[i].condition;
    result.fit->joint = joint;
    result.fit->stopped = is_incomplete(result.fit->posterior, cut, request.settings);
    result.fit->seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }
}

std::vector<FitGroup> with_singletons(std::vector<FitGroup> groups, std::size_t recordings) {
  std::vector<bool> taken(recordings, false);
  std::erase_if(groups, [](const FitGroup& group) { return group.recordings.empty(); });
  for (const FitGroup& group : groups)
    for (const std::size_t i : group.recordings) taken.at(i) = true;
  for (std::size_t i = 0; i < recordings; ++i)
    if (!taken[i]) groups.push_back({{i}});
  std::ranges::sort(groups, {}, [](const FitGroup& group) { return group.recordings.front(); });
  return groups;
}

bool Fitter::fit(std::span<RecordingResult> read, const FitProgress& progress, const OnFitted& fitted) {
  return fit_each(read, [this](std::size_t) -> Fitter& { return *this; }, progress, fitted, {});
}

bool fit_each(std::span<RecordingResult> read, const std::function<Fitter&(std::size_t recording)>& fitter_of,
              const FitProgress& progress, const OnFitted& fitted, std::span<const FitGroup> groups) {
  const std::vector<FitGroup> units = with_singletons({groups.begin(), groups.end()}, read.size());
  std::mutex reporting;
  std::atomic<bool> stopped{false};
  std::atomic<std::size_t> begun{0};
  parallel_for(static_cast<int>(units.size()), [&](int) {
    if (stopped) return;
    const FitGroup& unit = units[begun++];
    const auto report = [&](const posterior::Progress& here) {
      const std::lock_guard lock(reporting);
      for (const std::size_t i : unit.recordings)
        if (progress && !stopped && !progress(i, here)) stopped = true;
      return !stopped;
    };
    if (unit.recordings.size() > 1)
      Fitter::fit_together(read, fitter_of, unit, report);
    else if (RecordingResult& result = read[unit.recordings.front()]; !result.error)
      attempt(result, [&] {
        Fitter& fitter = fitter_of(unit.recordings.front());
        fitter.fit(result, fitter.prepare(result), report);
      });
    const std::lock_guard lock(reporting);
    for (const std::size_t i : unit.recordings) {
      if (read[i].error) read[i].fit.reset();
      if (fitted) fitted(i);
    }
  });
  return !stopped;
}

}  // namespace decid
