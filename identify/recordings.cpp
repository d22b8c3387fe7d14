// Recordings in files: see recordings.hpp.
#include "identify/recordings.hpp"

#include <iterator>

#include "base/parallel.hpp"
#include "base/setting.hpp"
#include "identify/body_warnings.hpp"
#include "identify/study/sheet.hpp"

namespace decid {

RecordingResult bring(recording::Recording recording, const recording::ProtocolPlan& plan,
                      const recording::TrialOptions& options, const std::optional<sim::Body>& body) {
  RecordingResult result;
  result.file = recording.file.empty() ? "recording" : recording.file;
  result.trial = recording::bring_to_protocol(recording, plan, options);
  result.column = recording.signals.at(recording::com_sway).column;
  if (const auto* tilt = recording.signals.find(recording::platform_tilt)) result.tilt_column = tilt->column;
  if (body) result.warnings = body_warnings(*body);
  std::ranges::move(recording.warnings, std::back_inserter(result.warnings));
  return result;
}

std::vector<RecordingSource> make_sources(const std::vector<std::filesystem::path>& files,
                                          const recording::RecordingOptions& options) {
  if (options.trial_column.empty()) return {files.begin(), files.end()};
  std::vector<std::vector<RecordingSource>> found(files.size());
  parallel_for(static_cast<int>(files.size()), [&](int place) {
    const auto i = static_cast<std::size_t>(place);
    if (files[i] == "-") return;
    try {
      for (const std::string& trial : recording::list_trials(files[i], options)) found[i].emplace_back(files[i], trial);
    } catch (const Error&) {
      found[i] = {files[i]};
    }
  });
  std::vector<RecordingSource> sources;
  for (const std::vector<RecordingSource>& some : found) {
    if (some.empty())
      throw Error(Code::setting_conflict, setting("trial_column"),
                  "does not go with standard input, which can be read only once", "name a file");
    sources.insert(sources.end(), some.begin(), some.end());
  }
  return sources;
}

RecordingResult read_source(const recording::ProtocolPlan& plan, const RecordingSource& source,
                            const ReadOptions& options) {
  RecordingResult result;
  const std::string file = source.name();
  try {
    recording::RecordingOptions reading = options.recording;
    reading.mean_is_upright = options.trial.detrend != recording::Detrend::none;
    reading.trial = source.trial;
    // Throws what make_sources() met.
    if (!reading.trial_column.empty() && reading.trial.empty()) recording::list_trials(source.file, reading);
    result = bring(recording::read_recording(source.file, reading), plan, options.trial, options.body);
  } catch (const Error& error) {
    const bool is_file = error.where() == source.file.string();
    result.error = is_file ? Error(error.code(), file, error.problem(), error.remedy()) : error;
    if (is_file && looks_like_sheet(source.file))
      result.error = Error(Code::file_unsupported, file, "looks like a study's sheet, not like a recording",
                           "give it with " + setting("study"));
  }
  result.file = file;
  result.truth = options.truth;
  return result;
}

std::vector<RecordingResult> read_recordings(const sim::Protocol& protocol, const std::vector<RecordingSource>& sources,
                                             const ReadOptions& options) {
  std::vector<RecordingResult> all(sources.size());
  const recording::ProtocolPlan plan(protocol);
  parallel_for(static_cast<int>(sources.size()), [&](int place) {
    const auto i = static_cast<std::size_t>(place);
    all[i] = read_source(plan, sources[i], options);
  });
  return all;
}

Report make_report(const Identifier& identifier) {
  const Model& model = identifier.model();
  const std::span<const float> tilt_rad = identifier.explainer().tilt_rad();
  Report report;
  report.protocol = identifier.body().protocol;
  report.body_assumed = identifier.body().assumed;
  report.tilt_rad.assign(tilt_rad.begin(), tilt_rad.end());
  report.image = model.image();
  report.image_shape = model.images().shape();
  report.recalibrated = model.recalibration.known();
  return report;
}

}  // namespace decid
