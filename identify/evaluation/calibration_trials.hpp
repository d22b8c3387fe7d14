// The trials of a calibration: simulated with known parameters, and with the start and gain that the priors allow.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "identify/evaluation/calibration.hpp"
#include "identify/identify.hpp"
#include "posterior/posterior.hpp"
#include "sim/simulate.hpp"

namespace decid {

/// Returns the protocol with the start and gain of every trial drawn from their priors.
sim::Protocol with_priors(sim::Protocol protocol, const posterior::Priors& priors);

/// Returns the standard deviations of uniform draws from the ranges. As divisors of errors they do not depend on which
/// trials were valid.
sim::Parameters uniform_stddev(const sim::ParameterTable& ranges);

/// Simulates valid trials of a seed, one after the other. Parameters that have a convention (sim::ParameterInfo) have
/// that value.
class CalibrationTrials {
 public:
  /// Simulates people who are recorded once with each protocol, with new noise, start and gain. Throws
  /// Error for no protocol, and for protocols of other parameters.
  CalibrationTrials(std::span<const sim::Protocol> protocols, const posterior::Priors& priors, std::uint64_t seed);

  struct Trial {
    std::uint64_t attempt;
    sim::Parameters truth;
    std::vector<float> sway_rad;                   ///< of the first protocol
    std::vector<std::vector<float>> others_rad{};  ///< of the other protocols
  };
  /// Continues from this attempt.
  void seek(std::uint64_t attempt) { next_ = attempt; }
  /// Throws Error if 10,000 trials in a row fall.
  Trial next();

 private:
  std::vector<sim::Simulator> simulators_;
  sim::ParameterTable ranges_;
  std::uint64_t seed_, next_ = 0;
};

/// Samples the posterior of a trial, of all its recordings together, seeded by its attempt, and compares it with the
/// truth. densities: of the protocols. Returns nothing if `stop` returned true meanwhile.
std::optional<CalibratedTrial> calibrate_trial(const std::deque<posterior::Density>& densities,
                                               const CalibrationTrials::Trial& trial, const sim::ParameterTable& ranges,
                                               posterior::Settings settings, const std::function<bool()>& stop);

/// The answers of a network to a calibration's trials; none if it is for another experiment.
class NetworkAnswers {
 public:
  NetworkAnswers(const Model& model, const sim::Protocol& protocol);
  /// Returns the SHA-256 of the network's weights; empty if the network is for another experiment.
  const std::string& sha256() const { return sha256_; }
  /// Stores the network's answer in the trial.
  void answer(const std::vector<float>& sway_rad, CalibratedTrial& trial);

 private:
  std::optional<Identifier> identifier_;
  std::string sha256_;
};

}  // namespace decid
