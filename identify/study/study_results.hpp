// Identifies and fits the recordings of a plan. An identifier or a fitter is made for each setting, so recordings of
// one body and protocol share it. Each result has the bits of a call of its own.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "identify/fit_recordings.hpp"
#include "identify/study/recording_plan.hpp"

namespace decid {

/// Identifies recordings of a plan. model and plan must outlive it.
class PlanIdentifier {
 public:
  /// name: the model's name in errors. at_once: recordings that identify() often gets. Loads the settings' protocols,
  /// for their bodies; `files` receives the names of the files read, unless null. A setting that the model does not
  /// cover is an error of its recordings if the plan has a sheet, and is thrown otherwise.
  PlanIdentifier(const Model& model, const std::string& name, const RecordingPlan& plan, std::size_t at_once,
                 std::vector<std::string>* files = nullptr);
  PlanIdentifier(const PlanIdentifier&) = delete;
  PlanIdentifier& operator=(const PlanIdentifier&) = delete;
  ~PlanIdentifier();

  /// Returns a report without recordings.
  Report report();
  /// Reads, identifies and explains recordings, by their places in the plan.
  std::vector<RecordingResult> identify(std::span<const std::size_t> places);

 private:
  Identifier& identifier(std::size_t setting);

  const Model& model_;
  const RecordingPlan& plan_;
  std::size_t at_once_;
  std::vector<ForBody> bodies_;               // of each setting
  std::vector<std::optional<Error>> errors_;  // of each setting
  std::size_t current_ = 0;
  std::unique_ptr<Identifier> identifier_;  // of the setting current_
};

/// Fits recordings of a plan. model and plan must outlive it.
class PlanFitter {
 public:
  /// protocol: of settings that name none. Loads the other protocols; `files` receives the names of the files read,
  /// unless null. A setting that cannot be fitted is an error of its recordings if the plan has a sheet, and is thrown
  /// otherwise.
  PlanFitter(const Model* model, const sim::Protocol& protocol, const RecordingPlan& plan, const FitRequest& request,
             std::vector<std::string>* files = nullptr);

  /// Returns a report without recordings.
  Report report() const;
  /// Reads recordings, by their places in the plan, and brings each to its protocol. If the bodies differ and the
  /// request has priors of gains in N m/rad, each has a note (`priors_of_all_bodies`).
  std::vector<RecordingResult> read(std::span<const std::size_t> places) const;
  /// Fits what read() returned, as fit_each(); groups: by their places in `read`.
  bool fit(std::span<RecordingResult> read, const FitProgress& progress, const OnFitted& fitted,
           std::span<const FitGroup> groups = {});

 private:
  const RecordingPlan& plan_;
  std::vector<std::unique_ptr<Fitter>> fitters_;  // of each setting; null: it has an error
  std::vector<std::optional<Error>> errors_;
  Report none_;         // of a plan without a setting that can be fitted
  Warnings of_bodies_;  // of all recordings
};

/// Sets the parts of a result that the plan says, and adds the plan's warnings, unless it has them.
void set_planned(RecordingResult& result, const PlannedRecording& planned);

/// Adds a warning (`same_content`) to recordings whose sway is another one's, sample by sample, unless they have it: a
/// copy in a file of another format, or a column or a sheet that is named in two ways.
void warn_of_same_sway(std::span<RecordingResult> recordings);

/// Identifies all recordings of a plan. files: receives the names of the protocols' files, unless null.
Report identify_plan(const Model& model, const std::string& name, const RecordingPlan& plan,
                     std::vector<std::string>* files = nullptr);

}  // namespace decid
