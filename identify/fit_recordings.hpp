// Recordings in files on their way to posteriors: read and brought to a protocol, sampled, explained. One that cannot
// be used does not stop the others.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "identify/predictive_check.hpp"
#include "identify/recordings.hpp"
#include "posterior/density/inferred.hpp"

namespace decid {

struct FitRequest {
  posterior::Priors priors;  ///< where a recording's tilt was measured, its start is known
  posterior::Settings settings;
};

/// What a fit found besides the parameters and how well they explain the recording.
struct FitFigures {
  /// Whose the estimate is: the posterior's mean or, if its chains do not agree, the network's answer.
  enum class Answer { posterior, network };
  Answer answer = Answer::posterior;
  posterior::Posterior posterior;
  std::optional<sim::Parameters> network;  ///< its answer, where it knows the experiment
  posterior::Inferred inferred;
  PredictiveCheck check;
  double samples_noise_deg = 0.0;  ///< the sensor's noise by the samples' second differences
  double block_s = 0.0;            ///< of what is inferred and checked; the first block begins with the trial
  double edge_s = 0.0;             ///< from one edge of inferred signals to the next
  double first_edge_s = 0.0;
  double seconds = 0.0;
  bool stopped = false;  ///< before there were as many draws as are wanted
};
const char* name(FitFigures::Answer answer);

/// The recordings of one call; their estimates have no images. fits: in their order; that of a recording with an error
/// means nothing.
struct FittedRecordings {
  Identifications identified;
  std::vector<FitFigures> fits;
};

/// Where the work stands: the recording, counted from 0, and its sampling. Returns false to stop. Called by one thread
/// at a time; several recordings are fitted side by side.
using FitProgress = std::function<bool(std::size_t recording, const posterior::Progress& progress)>;

/// Called for each recording that was begun when it is done or has an error, by one thread at a time; it may leave
/// all.fits[recording] empty. Others are still being written.
using OnFitted = std::function<void(FittedRecordings& all, std::size_t recording)>;

/// Reads each recording, samples its posterior in `protocol`, with the body of `options` if it has one, and checks
/// whether its draws predict the recording; if they do not, the explanation's first warning says so. If chains do not
/// agree, a warning says so, and the estimate is the network's where `model`, which may be null, knows the protocol's
/// experiment. A run that is stopped keeps what was drawn until then, and begins no other recording. What comes out
/// does not depend on the number of threads. Throws Error if the protocol cannot be fitted; an error of a recording is
/// its own.
FittedRecordings fit_recordings(const Model* model, sim::Protocol protocol, const std::vector<RecordingSource>& sources,
                                const ReadOptions& options, const FitRequest& request, const FitProgress& progress = {},
                                const OnFitted& fitted = {});
/// The same for recordings that have been read, as read_recordings() does for `protocol`; body: the subject's, if it is
/// known.
FittedRecordings fit_recordings(const Model* model, sim::Protocol protocol, std::vector<Identification> read,
                                const std::optional<sim::Body>& body, const FitRequest& request,
                                const FitProgress& progress = {}, const OnFitted& fitted = {});

}  // namespace decid
