// The mean frequency response of a controller over its vestibular noise, at a table's frequencies: the closed loop of
// the simulator's own 1 ms steps, for every member of the family (sim/family.hpp), with the dead band replaced by its
// mean output.
//
// The dead band acts on the platform's velocity r plus the noise's velocity n, Gaussian and independent of r, and has
// no memory. Its mean output is a function of r only, at Nv, theta and the noise's standard deviation d:
//   m(r) = E f_theta(r + n) = d [G((r - theta) / d) - G((-r - theta) / d)],   G(u) = u Phi(u) + phi(u),
// and the rest is linear except sin(a). Over the steady cycle, the transform of m at the stimulus' harmonics over that
// of r is the gain g. This is exact, unlike a describing function for a sine. A ternary sequence has one speed v in
// both directions, so its g = m(v) / v at all frequencies. With s = d/dt of the steps, forwards and backwards (s_f =
// z s_b), and the family's coefficients,
//   H = (kp_pass + kd_pass s_f + K (kp + kd s_f) (position - tilt g)) /
//       (J s_f s_b - m g h + kp_pass + kd_pass s_b +
//        K ((position + gravity) (kp + kd s_b) + (kp + kd s_f) slow / (s_f + 1 / slow_time))),
//   1 / K = exp(s delay) - torque / (m g h) (kp + kd s_f) / (z (s_f + 1 / torque_time)).
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
  /// frequency. Throws Error if the protocol is invalid or its body model is not of the family, and if its stimulus has
  /// no frequency response (sim::FrequencyResponse). Throws Error for a frequency farther than 1 / cycle from each of
  /// the stimulus' harmonics, and for more harmonics than the stimulus has.
  ResponseModel(const sim::Protocol& protocol, const Table& table);

  const sim::Protocol& protocol() const noexcept { return protocol_; }
  std::size_t rows() const noexcept { return bands_.size(); }

  /// The derivatives of a response in rad/rad: by each sim::Coefficient in its place, except nv and theta, which act
  /// through the passing gain g; then by g.
  static constexpr std::size_t by_passed = sim::Coefficients::count, derivatives = by_passed + 1;

  /// Computes the response at each row, sway over tilt in rad/rad, rows() values, and its derivatives, `derivatives`
  /// per row, if the span is not empty. They are meaningful only if the loop is stable.
  void respond(const sim::Parameters& parameters, std::span<sim::Complex> responses,
               std::span<sim::Complex> derived = {}) const;
  /// Returns the mean gain of the dead band for the platform's velocity over the cycle, by least squares; the g of a
  /// ternary sequence. It has no unit; nv: without unit, theta: rad/s.
  double passing_gain(double nv, double theta) const;
  struct PassingSlopes {
    double by_nv, by_theta;
  };
  /// Returns the derivatives of passing_gain().
  PassingSlopes passing_slopes(double nv, double theta) const;
  /// Returns whether the closed loop is stable without theta and noise (stability.hpp).
  bool is_stable(const sim::Parameters& parameters) const;

 private:
  struct Level {
    double rate_rad_s, fraction;  // above 0; of the cycle's intervals
  };
  struct Line {  // one frequency
    double frequency_hz, weight;
    sim::Complex forward, backward, body;  // s_f, s_b, J s_f s_b - m g h
    sim::Complex slow, torque;             // 1 / (s_f + 1 / slow_time), 1 / (m g h z (s_f + 1 / torque_time))
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
