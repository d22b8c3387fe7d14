// Recordings in files: see recordings.hpp.
#include "identify/recordings.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>

#include "base/parallel.hpp"
#include "base/setting.hpp"

namespace decid {
namespace {

/// Enough to keep all threads busy, few enough to hear of them. An answer does not depend on its company.
constexpr std::size_t recordings_at_once = 32;

/// Fills in the answers of those that could be read.
void identify_read(Identifier& identifier, std::vector<Identification>& recordings) {
  std::vector<Identification*> usable;
  std::vector<recording::Trial> trials;
  for (Identification& id : recordings) {
    if (id.error) continue;
    usable.push_back(&id);
    trials.push_back(std::move(id.estimate.trial));
  }
  std::vector<Estimate> estimates = identifier.estimate(std::move(trials));
  std::vector<Explanation> explanations = identifier.explain(estimates);
  for (std::size_t i = 0; i < usable.size(); ++i) {
    Warnings warnings = std::move(usable[i]->estimate.warnings);
    usable[i]->estimate = std::move(estimates[i]);
    usable[i]->explanation = std::move(explanations[i]);
    warnings.insert(warnings.end(), usable[i]->estimate.warnings.begin(), usable[i]->estimate.warnings.end());
    usable[i]->estimate.warnings = std::move(warnings);
  }
}

}  // namespace

double Identification::peak_to_peak_deg() const {
  const std::vector<float>& sway_rad = estimate.trial.sway_rad();
  if (sway_rad.empty()) return 0.0;
  if (std::ranges::any_of(sway_rad, [](float value) { return std::isnan(value); })) return std::nan("");
  const auto [low, high] = std::ranges::minmax(sway_rad);
  return static_cast<double>(high - low) / sim::rad_per_deg;
}

Warnings Identification::warnings() const {
  Warnings all = estimate.warnings;
  all.insert(all.end(), explanation.warnings.begin(), explanation.warnings.end());
  std::ranges::stable_sort(all, std::greater<>(), &Warning::severity);
  return all;
}

std::vector<RecordingSource> sources_of(const std::vector<std::filesystem::path>& files,
                                        const recording::RecordingOptions& options) {
  if (options.trial_column.empty()) return {files.begin(), files.end()};
  std::vector<std::vector<RecordingSource>> found(files.size());
  parallel_for(static_cast<int>(files.size()), [&](int place) {
    const auto i = static_cast<std::size_t>(place);
    if (files[i] == "-") return;
    try {
      for (const std::string& trial : recording::trials_of(files[i], options)) found[i].emplace_back(files[i], trial);
    } catch (const Error&) {
      found[i] = {files[i]};
    }
  });
  std::vector<RecordingSource> sources;
  for (const std::vector<RecordingSource>& some : found) {
    if (some.empty())
      throw Error(setting("trial_column"), "does not go with standard input, which can be read only once",
                  "name a file");
    sources.insert(sources.end(), some.begin(), some.end());
  }
  return sources;
}

std::vector<Identification> read_recordings(const sim::Protocol& protocol, const std::vector<RecordingSource>& sources,
                                            const ReadOptions& options) {
  std::vector<Identification> all(sources.size());
  recording::RecordingOptions reading = options.recording;
  reading.mean_is_upright = options.trial.detrend != recording::Detrend::none;
  const recording::ProtocolPlan plan(protocol);
  parallel_for(static_cast<int>(sources.size()), [&](int place) {
    const auto i = static_cast<std::size_t>(place);
    Identification& id = all[i];
    id.file = sources[i].name();
    id.truth = options.truth;
    try {
      recording::RecordingOptions its_own = reading;
      its_own.trial = sources[i].trial;
      // Throws what sources_of() met.
      if (!its_own.trial_column.empty() && its_own.trial.empty()) recording::trials_of(sources[i].file, its_own);
      recording::Recording recording = recording::read_recording(sources[i].file, its_own);
      id.estimate.trial = recording::bring_to_protocol(recording, plan, options.trial);
      id.column = recording.signals.at(recording::com_sway).column;
      if (const auto* tilt = recording.signals.find(recording::platform_tilt)) id.tilt_column = tilt->column;
      id.estimate.warnings = std::move(recording.warnings);
    } catch (const Error& error) {
      const bool is_file = error.where() == sources[i].file.string();
      id.error = is_file ? Error(id.file, error.problem(), error.remedy()) : error;
    }
  });
  return all;
}

Identifications identify_files(const Model& model, const std::string& name, const std::vector<RecordingSource>& sources,
                               const ReadOptions& options, const std::function<void(std::size_t)>& done) {
  Identifier identifier(model, for_body(model, name, options.body), std::min(sources.size(), recordings_at_once));
  const std::span<const float> tilt_rad = identifier.explainer().tilt_rad();
  Identifications all{
      identifier.body().protocol, {tilt_rad.begin(), tilt_rad.end()}, model.image(), model.images().shape(), {},
      identifier.body().assumed};
  all.recordings.reserve(sources.size());
  for (std::size_t first = 0; first < sources.size(); first += recordings_at_once) {
    const auto begin = sources.begin() + static_cast<std::ptrdiff_t>(first);
    const std::size_t count = std::min(recordings_at_once, sources.size() - first);
    std::vector<Identification> some =
        read_recordings(model.protocol, {begin, begin + static_cast<std::ptrdiff_t>(count)}, options);
    identify_read(identifier, some);
    std::ranges::move(some, std::back_inserter(all.recordings));
    if (done) done(all.recordings.size());
  }
  return all;
}

}  // namespace decid
