// Results: of one recording, and of a call. Text, JSON, tables, pages and the C interface are views of these values.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "dataset/image/image.hpp"
#include "identify/estimate.hpp"
#include "identify/groups.hpp"
#include "identify/predictive_check.hpp"
#include "identify/study/sheet.hpp"
#include "posterior/density/inferred.hpp"
#include "posterior/sampling/model_comparison.hpp"
#include "recording/trial.hpp"

namespace decid {

struct FitRequest {
  posterior::Priors priors;  ///< where a recording's tilt was measured, its start is known; may be over m g h
  posterior::Settings settings;
  bool keeps_log_likelihood = false;  ///< posterior::Inferred::log_likelihood
  /// A controller that is fitted too, and compared with the protocol's, and the priors of its parameters.
  struct Other {
    const sim::BodyModel* controller;
    std::vector<posterior::ParameterPrior> parameters{};
  };
  std::vector<Other> others{};
  /// Parameters that may differ between conditions where recordings are fitted together (FitGroup).
  std::vector<std::string> freed{};
};

/// The fit of another controller to the same recording.
struct ControllerFit {
  std::string controller;  ///< its name
  posterior::Posterior posterior;
  posterior::Band sway_rad;  ///< as Inferred::sway_rad
  PredictiveCheck check;
  posterior::ComparedModel compared;
  Warnings warnings;  ///< of its posterior and of its check
  /// Its predictions can be compared: its chains agree (chains_allow_comparison()), and no warning is `invalid`.
  bool comparable = true;
};

/// The recordings that were fitted together with one.
struct JointFit {
  std::vector<std::string> files;  ///< of all, its own too
  std::vector<std::string> freed;  ///< parameters that only recordings of one condition have in common
  std::string condition;           ///< of the recording
};

/// A fit: the posterior, and the signals and checks that come from it.
struct FitFigures {
  /// Source of the estimate: the posterior's means or, if its chains are far apart, the network.
  enum class Answer { posterior, network };
  Answer answer = Answer::posterior;
  posterior::Posterior posterior;
  std::optional<sim::Parameters> network;  ///< the network's answer, if it covers the experiment
  posterior::Inferred inferred;
  std::vector<int> stored_draws;  ///< the draws of Inferred::log_likelihood, chain by chain
  PredictiveCheck check;
  double samples_noise_deg = 0.0;  ///< white measurement noise, by the power above 2 Hz
  double block_s = 0.0;            ///< of what is inferred and checked; the first block begins with the trial
  double edge_s = 0.0;             ///< from one edge of inferred signals to the next
  double first_edge_s = 0.0;
  double seconds = 0.0;
  bool stopped = false;  ///< before there were as many draws as are wanted
  /// The place of this fit among all fitted controllers, and the others; empty if only one was fitted.
  std::optional<posterior::ComparedModel> compared{};
  std::vector<ControllerFit> others{};
  bool comparable = true;           ///< by chains_allow_comparison(); true if only one was fitted
  std::optional<JointFit> joint{};  ///< empty: the recording was fitted alone
};
const char* name(FitFigures::Answer answer);

/// The results of one recording: read and brought to the protocol; then identified or fitted, and explained.
struct RecordingResult {
  std::string file;
  std::optional<Error> error = {};       ///< why the recording could not be used; if set, nothing below is
  std::string column, tilt_column;       ///< the columns that were read; tilt_column may be empty
  std::optional<sim::Parameters> truth;  ///< when known (a simulated recording)
  recording::Trial trial;                ///< the recording at the protocol's rate and length
  Estimate estimate;
  Explanation explanation;
  std::optional<FitFigures> fit = {};  ///< empty if only the network answered
  Warnings warnings = {};   ///< of all steps, most severe first, else in their order; those of the parts are here too
  std::size_t setting = 0;  ///< Report::setting_of()
  SheetEntry entry = {};    ///< of a study's sheet
  std::optional<double> mass_kg = {}, height_m = {};  ///< of the person, by the sheet

  double peak_to_peak_deg() const;
  Trust trust() const { return worst_trust(warnings); }
};

/// Calls use() with the distribution of a result: the posterior's or the network's. Does nothing if there is none.
template <class Use>
void use_distribution(const RecordingResult& result, const Use& use) {
  if (result.fit && result.fit->answer == FitFigures::Answer::posterior)
    use(result.fit->posterior);
  else if (result.estimate.distribution)
    use(*result.estimate.distribution);
}

/// Returns the warnings of several lists, the most severe first, else in their order. Among cautions `scale_unlikely`
/// is first, and those of how the file was read (`part_not_used` and others) are last.
Warnings most_severe_first(std::initializer_list<Warnings> lists);

/// A protocol with a subject's body, and what follows from them.
struct ReportSetting {
  sim::Protocol protocol;       ///< with the subject's body, or the one that is assumed
  bool body_assumed = true;     ///< no body was given
  std::vector<float> tilt_rad;  ///< the platform at the trials' samples
};

/// A file that a call read. Pipes and standard input have no hash.
struct InputFile {
  std::string file, sha256;
};

/// The call that computed a result: with it decid rerun computes the result again.
struct Call {
  std::string command = {};                 ///< such as "fit"
  std::vector<std::string> arguments = {};  ///< of the command, except outputs, as given
  std::vector<InputFile> inputs = {};       ///< the files that the result depends on
  std::optional<std::uint64_t> seed = {};   ///< of the command's random numbers
};

/// The recordings of one call, and their common values.
struct Report : ReportSetting {
  dataset::ImageSettings image;        ///< of the network; unset for a fit
  dataset::ImageShape image_shape{};   ///< of Estimate::image, where that is not empty
  std::optional<FitRequest> fit = {};  ///< settings of a fit
  bool network_answers = true;         ///< the model's network covers the experiment
  std::string model, model_sha256;     ///< its name and that of its weights, or empty
  bool recalibrated = false;           ///< so are the network's distributions
  std::vector<std::string> options;    ///< given options that change the answers, such as --unit rad
  std::vector<RecordingResult> recordings;
  std::optional<GroupReport> groups = {};
  /// Other bodies and protocols of a study, for RecordingResult::setting 1, 2, ...; 0 is the report's own.
  std::vector<ReportSetting> other_settings = {};
  std::optional<StudySheet> sheet = {};
  Call call = {};

  const ReportSetting& setting_of(const RecordingResult& recording) const {
    if (recording.setting == 0) return *this;
    return other_settings.at(recording.setting - 1);
  }
  const sim::Protocol& protocol_for(const RecordingResult& recording) const { return setting_of(recording).protocol; }

  /// Returns the parameters with their ranges: the body's, or the requested ones.
  sim::ParameterTable ranges() const;
  /// Returns the parameters with their ranges for the recording's body.
  sim::ParameterTable ranges_for(const RecordingResult& recording) const;
  /// Returns the priors of the fit in SI units, for the recording's body; the default ones without a fit.
  posterior::Priors priors_for(const RecordingResult& recording) const;

  /// Returns the names of the parameters that a fit's priors fix.
  std::vector<std::string> fixed_parameters() const;
  /// Returns the places of the others: what recordings tell, and groups compare.
  std::vector<std::size_t> inferred_parameters() const;
  /// Returns the parameters that groups compare, in the order of their lists. Throws Error if there is none.
  sim::ParameterTable compared_parameters() const;
};

/// Returns the factor that scales a recording's parameter to a body of this m g h: for stiffness and damping the ratio
/// of both m g h, otherwise 1.
double scale_to(double mgh_nm_rad, const Report& report, const RecordingResult& result, std::size_t parameter);

/// Returns why groups do not compare a recording, and why it is not fitted together with others: "error", "not usable"
/// or "tilt_of_other_size"; empty if they do.
std::string reason_to_leave_out(const RecordingResult& result);

/// Compares the groups of `table`, whose members are those of the report's recordings, in their order. Leaves out
/// recordings with an error, those that are not usable, and those of a platform that tilted another angle; and fixed
/// parameters, which are the same for every participant. Throws Error if all parameters are fixed.
GroupReport report_groups(GroupTable table, const Report& report);

}  // namespace decid
