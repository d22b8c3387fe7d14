// The fits of a call: see fit_all.hpp.
#include "tools/decid/commands/fit_all.hpp"

#include <algorithm>
#include <filesystem>
#include <numeric>
#include <utility>

#include "base/files/file.hpp"
#include "base/files/sha256.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"
#include "identify/result_archive.hpp"
#include "identify/study/joint_groups.hpp"
#include "tools/decid/interrupt.hpp"
#include "tools/decid/progress.hpp"
#include "tools/decid/ranks.hpp"

namespace decid::tools {
namespace {

/// The progress of all recordings, for the bar.
class FitProgressBar {
 public:
  FitProgressBar(const FitResults& results, bool quiet)
      : done_(results.size()),
        bar_("Analysing", results.size() > 1 ? "recordings" : "%",
             static_cast<long long>(results.size() > 1 ? results.size() : parts), quiet,
             results.size() > 1 ? parts : 1) {
    for (std::size_t i = 0; i < results.size(); ++i) done_[i] = results[i] ? 1.0 : 0.0;
    bar_.go_on_from(all());
  }
  /// Updates one recording's progress. Only one thread at a time may call it.
  void update(std::size_t recording, double done, const std::string& note = {}) {
    done_[recording] = done;
    bar_.update(all(), note);
  }

 private:
  static constexpr int parts = 100;  // of a recording
  long long all() const { return static_cast<long long>(parts * std::accumulate(done_.begin(), done_.end(), 0.0)); }

  std::vector<double> done_;
  ProgressBar bar_;
};

/// Returns a recording's own settings and warnings by the plan, for the journal; empty if there are none.
std::string own_settings(const RecordingPlan& plan, std::size_t i) {
  const PlannedRecording& planned = plan.recordings[i];
  if (!plan.sheet && planned.warnings.empty()) return {};
  std::string text = plan.settings[planned.setting].protocol;
  if (std::error_code ignored; std::filesystem::is_regular_file(text, ignored)) text += sha256(read_file(text));
  for (const std::optional<double>& value : {planned.mass_kg, planned.height_m})
    text += '\n' + (value ? format("%.17g", *value) : std::string());
  for (const auto& [name, value] : planned.options) text += '\n' + name + '=' + value;
  for (const Warning& warning : planned.warnings) text += '\n' + warning.text;  // results keep theirs
  return text;
}

/// Gives each recording of a group that the journal does not have its error, if the journal has others of the group:
/// they were fitted without it. Returns false if a recording is left to fit.
bool set_errors(const FitGroup& group, const FitCall& call, const PlanFitter& fitter, FitResults& results) {
  std::vector<std::size_t> missing;
  for (const std::size_t i : group.recordings)
    if (!results[i]) missing.push_back(i);
  if (missing.empty()) return true;
  if (missing.size() == group.recordings.size()) return false;
  // Standard input can be read only once, by the fit.
  if (std::ranges::any_of(missing, [&](std::size_t i) { return call.sources[i].file == "-"; })) return false;
  std::vector<RecordingResult> read = fitter.read(missing);
  if (!std::ranges::all_of(read, [](const RecordingResult& one) { return one.error.has_value(); })) return false;
  for (std::size_t k = 0; k < missing.size(); ++k) results[missing[k]] = std::move(read[k]);
  return true;
}

/// Returns the journal's keys of a group's recordings. Results of recordings that are fitted together depend on all.
std::vector<std::string> journal_keys(const FitGroup& group, const std::vector<RecordingSource>& sources,
                                      const RecordingPlan& plan) {
  std::vector<std::string> keys;
  std::string all;
  for (std::size_t k = 0; k < group.recordings.size(); ++k) {
    const std::size_t i = group.recordings[k];
    all += keys.emplace_back(FitJournal::key(sources[i], own_settings(plan, i)));
    if (!group.conditions.empty()) all += '\n' + group.conditions[k];
  }
  if (keys.size() == 1) return keys;
  for (std::string& key : keys)
    if (!key.empty()) key = sha256(key + '\n' + all);
  return keys;
}

/// Sets the keys of all recordings, and the results that the journal has. Returns the places of the groups that are
/// left to fit. journal: null for none.
std::vector<std::size_t> groups_to_fit(const FitCall& call, const std::vector<FitGroup>& groups,
                                       const PlanFitter& fitter, const RecordingPlan& plan, const FitJournal* journal,
                                       std::vector<std::string>& keys, FitResults& results) {
  std::vector<std::size_t> left;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const std::vector<std::size_t>& members = groups[g].recordings;
    if (journal != nullptr) {
      const std::vector<std::string> own = journal_keys(groups[g], call.sources, plan);
      for (std::size_t k = 0; k < members.size(); ++k) {
        keys[members[k]] = own[k];
        std::optional<RecordingResult> found = journal->find(own[k]);
        const bool lacks_likelihood = found && found->fit && found->fit->inferred.log_likelihood.empty();
        if (lacks_likelihood && fitter.report().fit->keeps_log_likelihood) found.reset();
        results[members[k]] = std::move(found);
      }
    }
    const bool done = set_errors(groups[g], call, fitter, results);
    if (!done) left.push_back(g);
    for (const std::size_t i : members) {
      if (!done) results[i].reset();
      if (results[i]) set_planned(*results[i], plan.recordings[i]);
    }
  }
  return left;
}

}  // namespace

FitResults fit_all(const FitCall& call, PlanFitter& fitter, const RecordingPlan& plan, FitJournal* journal) {
  require_same("the list of recordings", call.files, "give all hosts the same files");
  FitResults results(call.sources.size());
  const std::vector<FitGroup> groups = with_singletons(
      call.joint.empty() ? std::vector<FitGroup>() : joint_groups(plan, call.joint, call.conditions), results.size());
  std::vector<std::string> keys(call.sources.size());
  // All ranks fit the groups that rank 0 finds.
  const std::vector<std::size_t> left =
      broadcast_value(groups_to_fit(call, groups, fitter, plan, journal, keys, results));
  FitProgressBar bar(results, call.quiet);
  const bool alone = ranks() == nullptr;
  share_out<std::vector<RecordingResult>>(
      left.size(), alone ? left.size() : static_cast<std::size_t>(thread_count()),
      [&](std::size_t first, std::size_t last, const Give<std::vector<RecordingResult>>& give) {
        std::vector<std::size_t> places, group_of, missing;  // recordings of these groups; of a group, those to come
        std::vector<FitGroup> here;
        for (std::size_t g = first; g < last; ++g) {
          const FitGroup& group = groups[left[g]];
          FitGroup& local = here.emplace_back(FitGroup{{}, group.conditions});
          for (const std::size_t i : group.recordings) {
            local.recordings.push_back(places.size());
            places.push_back(i);
            group_of.push_back(g - first);
          }
          missing.push_back(group.recordings.size());
        }
        std::vector<RecordingResult> read = fitter.read(places);
        fitter.fit(
            read,
            [&](std::size_t i, const posterior::Progress& now) {
              if (alone)
                bar.update(places[i], now.done,
                           now.rhat > 0.0 ? format("%s, R-hat %.2f", now.stage, now.rhat) : now.stage);
              return !interrupted();
            },
            [&](std::size_t i) {
              const std::size_t g = group_of[i];
              if (--missing[g] > 0) return;
              std::vector<RecordingResult> fitted;
              for (const std::size_t k : here[g].recordings) fitted.push_back(std::move(read[k]));
              give(first + g, std::move(fitted));
            },
            here);
      },
      [&](std::size_t number, std::vector<RecordingResult> fitted) {
        const std::vector<std::size_t>& members = groups[left[number]].recordings;
        for (std::size_t k = 0; k < members.size(); ++k) {
          const std::size_t i = members[k];
          if (journal != nullptr && !fitted[k].error && !fitted[k].fit->stopped) journal->append(keys[i], fitted[k]);
          set_planned(fitted[k], plan.recordings[i]);
          results[i] = std::move(fitted[k]);
          bar.update(i, 1.0);
        }
      },
      interrupted);
  return results;
}

}  // namespace decid::tools
