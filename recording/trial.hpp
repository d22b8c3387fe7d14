// Recordings brought to a protocol: its rate, its length, its start.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "recording/recording.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::recording {

/// What is subtracted from a trial. `offset`: its mean. `linear`: a straight line too. Both are those of the protocol's
/// whole cycles, about whose mean simulated trials swing. The line's slope is that of the cycles' means: the response
/// to the stimulus is the same in each cycle and leaves it alone; with one cycle it is the line of least squares.
enum class Detrend { none, offset, linear };

struct TrialOptions {
  std::optional<double> start_s = {};  ///< where in the recording the protocol starts; empty: at its first sample, or
                                       ///< where the tilt says
  Detrend detrend = Detrend::none;
};

/// How the measured tilt lies over the tilt that the protocol prescribes.
struct TiltMatch {
  double delay_s = 0.0;      ///< the protocol starts so long after the recording's first sample
  double correlation = 0.0;  ///< over the trial, at that delay
  double gain = 0.0;         ///< measured over prescribed tilt, by least squares
  /// Whether the platform played the end of the protocol's last cycle before the start, or rested; empty: unknown, or
  /// it moved otherwise.
  std::optional<bool> moved_before = {};
  bool is_other_size = false;  ///< the gain is off by more than 10%, which has been warned of
};

/// A recording brought to a protocol.
struct Trial {
  Signals<float> signals;         ///< the recording's, at the protocol's samples
  std::optional<TiltMatch> tilt;  ///< if the recording has one
  bool is_large = false;          ///< as the recording's, which has been warned of

  /// That of com_sway. Throws Error if there is none.
  std::vector<float>& sway_rad() & { return signals.at(com_sway).rad; }
  const std::vector<float>& sway_rad() const& { return signals.at(com_sway).rad; }
  std::vector<float> sway_rad() && { return std::move(signals.at(com_sway).rad); }
};
/// A trial of the protocol's samples of sway alone.
Trial trial_of(std::vector<float> sway_rad);

class TiltMatcher;
class ResponseCheck;

/// A protocol that many recordings are brought to: what is looked for in their tilts and sways is made once, with the
/// first that needs it. One serves all threads. The protocol must outlive it.
class ProtocolPlan {
 public:
  explicit ProtocolPlan(const sim::Protocol& protocol);
  ~ProtocolPlan();

  const sim::Protocol& protocol() const noexcept { return protocol_; }
  const TiltMatcher& tilt() const;
  const ResponseCheck& response() const;

 private:
  const sim::Protocol& protocol_;
  mutable std::mutex making_;
  mutable std::unique_ptr<const TiltMatcher> tilt_;
  mutable std::unique_ptr<const ResponseCheck> response_;
};

/// The recording at the protocol's rate (resampled if the rates differ by more than 0.01%) and length. A recording of
/// less than 25 Hz and than the protocol's rate gets a caution; of less than 5 Hz, an Error.
/// A longer recording is cut: from start_s, or from where its tilt follows the protocol's best, else from its first
/// sample, with a warning that says what was left out. One that lacks up to 1% of the trial at either end is
/// continued by its mirror image, with a warning: that keeps its noise, where holding a value would show as silence.
/// At equal rates a start is rounded to a sample: filtering would change the noise that a model has learned.
/// Throws Error if more is missing, naming both lengths and rates, how many whole cycles there are and how to get a
/// model for them: none are made up, since what changes from cycle to cycle is what the noise is read from. Throws too
/// if start_s is not within the recording, or a tilt does not follow the protocol (correlation below 0.5) or follows it
/// with the other sign; a tilt that was found by its name alone is left out then, and beside start_s, with a warning.
/// Warns of what is cut, made up or resampled, of a correlation below 0.95, of a gain that is off by more than 10%, and
/// of what sensors and programs leave in the samples that are used: frozen stretches, coarse steps, single wrong
/// samples, smoothing (quality.hpp). These warnings are appended to the recording's.
Trial bring_to_protocol(Recording& recording, const sim::Protocol& protocol, const TrialOptions& options = {});
Trial bring_to_protocol(Recording& recording, const ProtocolPlan& plan, const TrialOptions& options = {});

}  // namespace decid::recording
