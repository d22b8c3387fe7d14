// Recordings brought to a protocol: its rate, its length, its start.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "recording/low_pass.hpp"
#include "recording/recording.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::recording {

/// The part to subtract from a trial. `offset`: its mean. `linear`: a straight line too. Both use the protocol's whole
/// cycles, about whose mean simulated trials sway. The slope is that of the cycles' means, which the response to the
/// stimulus does not affect because it is the same in each cycle. With one cycle it is the least-squares line.
enum class Detrend { none, offset, linear };

struct TrialOptions {
  /// The protocol's start in the recording; empty: the first sample, or as the tilt shows.
  std::optional<double> start_s = {};
  Detrend detrend = Detrend::none;
};

/// The relation of the measured tilt to the protocol's.
struct TiltMatch {
  double delay_s = 0.0;      ///< from the recording's first sample to the protocol's start
  double correlation = 0.0;  ///< over the trial, at that delay
  double gain = 0.0;         ///< measured over prescribed tilt, by least squares; NaN: the column has no unit
  /// True if the platform played the end of the protocol's last cycle before the start, false if it rested; empty:
  /// unknown, or it moved differently.
  std::optional<bool> moved_before = {};
  bool is_other_size = false;  ///< the gain is off by more than 10%, which has been warned of
};

/// A recording brought to a protocol.
struct Trial {
  Signals<float> signals;         ///< the recording's signals at the protocol's samples
  std::optional<TiltMatch> tilt;  ///< if the recording has one, and no start was given
  /// As `tilt`, but at the start that was given.
  std::optional<TiltMatch> tilt_at_given_start = {};
  bool is_large = false;  ///< as the recording's, which has a warning
  /// Samples of the sway that were not measured, ascending, in gaps of 0.05 s or more: filled on reading, bridged by a
  /// straight line, frozen, or lacking at an end.
  std::vector<SampleRange> gaps = {};
  std::optional<LowPass> low_pass = {};  ///< that smoothed the sway
  bool start_is_doubtful = false;        ///< a warning of the recording says so
  /// The sway follows the tilt as if the recording started this much after the protocol (negative: before it), to
  /// within 0.7 s, which the warning `other_start` says.
  std::optional<double> other_start_s = {};
  /// How much the linear response to the tilt improves the prediction of the sway (detail/prediction.hpp): the number
  /// of 0.1 s blocks times the relative decrease of the squared error. If that is below 60 from the protocol's start
  /// on, the largest of the starts 0, 0.3 and 0.6 s after it. About 15 for a sway that does not respond. Empty for
  /// trials under 40 s, for a constant, and for a sway that its own past determines.
  std::optional<double> response_gain = {};

  /// Returns the samples of com_sway. Throws Error without them.
  std::vector<float>& sway_rad() & { return signals.at(com_sway).rad; }
  const std::vector<float>& sway_rad() const& { return signals.at(com_sway).rad; }
  std::vector<float> sway_rad() && { return std::move(signals.at(com_sway).rad); }
};
/// Makes a trial that has only sway, at the protocol's samples.
Trial make_trial(std::vector<float> sway_rad);

class TiltMatcher;
class ResponseCheck;

/// A protocol for many recordings: the first that needs a search table for tilts or sways makes it. All threads may
/// share one plan. The protocol must outlive it, unchanged.
class ProtocolPlan {
 public:
  explicit ProtocolPlan(const sim::Protocol& protocol);
  ~ProtocolPlan();

  const sim::Protocol& protocol() const noexcept { return protocol_; }
  /// Returns the protocol's tilt in rad, one value per sample.
  const std::vector<double>& tilt_rad() const noexcept { return tilt_rad_; }
  const TiltMatcher& tilt() const;
  const ResponseCheck& response() const;

 private:
  const sim::Protocol& protocol_;
  std::vector<double> tilt_rad_;
  mutable std::mutex making_;
  mutable std::unique_ptr<const TiltMatcher> tilt_;
  mutable std::unique_ptr<const ResponseCheck> response_;
};

/// Returns the recording at the protocol's rate and length.
/// - Resamples if the rates differ by more than 0.01%. A recording below 25 Hz and below the protocol's rate gets a
/// caution, below 5 Hz an Error.
/// - Cuts a longer recording: from start_s, else from where its tilt follows the protocol best, else from its first
/// sample. A warning names the ignored samples.
/// - Continues a recording that lacks up to 1% of the trial at either end by its mirror image, with a warning. The
/// mirror image keeps the noise; a held value would be silent. The tilt goes on as prescribed, times its gain.
/// - At equal rates a start is rounded to a sample: filtering would change the noise that a model has learned.
/// Throws Error if more is missing, with both lengths and rates, the number of whole cycles and a way to a model for
/// them. decid invents no cycles, because the noise is estimated from changes between cycles. Throws Error if start_s
/// lies outside of the recording, or if a tilt does not follow the protocol (correlation below 0.5), follows it with
/// the other sign (correlation of -0.95 or below), or shows that the platform stood still for half of it. A tilt found
/// by its name or its values is then ignored with a warning. If start_s is given, it does not determine the start: it
/// is compared with the protocol there, with the same warnings. Warns of cut, invented or resampled samples, of a
/// correlation below 0.95, of a gain that is off by more than 10%, and of faults in the used samples: frozen stretches,
/// coarse steps, single wrong samples, smoothing (quality.hpp). Appends these warnings to the recording's.
Trial bring_to_protocol(Recording& recording, const sim::Protocol& protocol, const TrialOptions& options = {});
Trial bring_to_protocol(Recording& recording, const ProtocolPlan& plan, const TrialOptions& options = {});

}  // namespace decid::recording
