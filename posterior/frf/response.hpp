// The mean frequency response of a controller over its vestibular noise, at a table's frequencies: the closed loop of
// the simulator's own 1 ms steps, with the dead band replaced by its mean output.
//
// The dead band acts on the platform's velocity r plus the noise's velocity n, Gaussian and independent of r, and has
// no memory. Its mean output is a function of r only, at Nv, theta and the noise's standard deviation d:
//   m(r) = E f_theta(r + n) = d [G((r - theta) / d) - G((-r - theta) / d)],   G(u) = u Phi(u) + phi(u),
// and the rest is linear except sin(a). Over the steady cycle, the transform of m at the stimulus' harmonics over that
// of r is the gain g. This is exact, unlike a describing function for a sine. A ternary sequence has one speed v in
// both directions, so its g = m(v) / v at all frequencies. With s = d/dt of the steps, forwards and backwards,
//   H = (Kp_pass + Kd_pass s_f + exp(-s delay) (Kp + Kd s_f) (1 - g)) /
//       (J s_f s_b - m g h + Kp_pass + Kd_pass s_b + 2 exp(-s delay) (Kp + Kd s_b)).
#pragma once

#include <span>
#include <vector>

#include "posterior/frf/table.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::frf {

/// The model of a table's responses. Immutable: all threads may share it.
class ResponseModel {
 public:
  /// A row without a number of harmonics uses its own frequency, with the g of the adjacent harmonics. A row of n
  /// harmonics averages n neighbouring ones as sim::FrequencyResponse does, with the mean nearest to the row's
  /// frequency. Throws Error if the protocol is invalid or has another body model than the single pendulum, and if its
  /// stimulus has no frequency response (sim::FrequencyResponse). Throws Error for a frequency farther than 1 / cycle
  /// from each of the stimulus' harmonics, and for more harmonics than the stimulus has.
  ResponseModel(const sim::Protocol& protocol, const Table& table);

  const sim::Protocol& protocol() const noexcept { return protocol_; }
  std::size_t rows() const noexcept { return bands_.size(); }

  /// The variables of derivatives; g is the passing gain.
  enum Derivative { by_kp, by_kd, by_kp_pass, by_kd_pass, by_delay, by_passed, derivatives };

  /// Computes the response at each row, rows() values, and its derivatives, `derivatives` per row, if the span is not
  /// empty. They are meaningful only if the loop is stable.
  void respond(const sim::Parameters& parameters, std::span<sim::Complex> responses,
               std::span<sim::Complex> derived = {}) const;
  /// Returns the mean gain of the dead band for the platform's velocity over the cycle, by least squares; the g of a
  /// ternary sequence.
  double passing_gain(double nv, double theta) const;
  /// Returns whether the closed loop is stable without theta and noise, by the one delay at which it oscillates.
  bool is_stable(const sim::Parameters& parameters) const;

 private:
  struct Level {
    double rate_rad_s, fraction;  // above 0; of the cycle's intervals
  };
  struct Line {  // one frequency
    double frequency_hz, weight;
    sim::Complex forward, backward, body;  // s_f, s_b, J s_f s_b - m g h
  };
  struct Band {  // of a row
    std::vector<Line> lines;
    std::vector<sim::Complex> passing;  // g is the sum of these times m at the levels
  };
  Line line_at(double frequency_hz, double weight) const;

  sim::Protocol protocol_;
  double noise_rad_s_;         // of the noise's velocity at Nv = 1
  std::vector<Level> levels_;  // velocities of the platform
  std::vector<Band> bands_;
};

/// Returns the mean output of a dead band of threshold theta, for a signal and Gaussian noise of this standard
/// deviation.
double mean_passed(double signal, double stddev, double theta);

}  // namespace decid::frf
