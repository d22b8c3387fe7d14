// The frequency response that a controller has on average over its vestibular noise, at a table's frequencies: the
// closed loop of the simulator's own 1 ms steps, its dead band replaced by what it passes of the stimulus.
//
// The dead band acts on the platform's velocity r plus the noise's velocity n, Gaussian and independent of r, and has
// no memory. So the mean of what passes is a function of r alone, at Nv, theta and the noise's standard deviation:
//   m(r) = E f_theta(r + n) = d [G((r - theta) / d) - G((-r - theta) / d)],   G(u) = u Phi(u) + phi(u),
// and behind it all is linear but for sin(a). Over the steady cycle its transform at the stimulus' harmonics, over that
// of r, is the gain g: no approximation, unlike a describing function for a sine. A ternary sequence has one velocity
// v, forth and back, so its g = m(v) / v at all frequencies. With s = d/dt of the steps, forwards and backwards,
//   H = (Kp_pass + Kd_pass s_f + exp(-s delay) (Kp + Kd s_f) (1 - g)) /
//       (J s_f s_b - m g h + Kp_pass + Kd_pass s_b + 2 exp(-s delay) (Kp + Kd s_b)).
#pragma once

#include <span>
#include <vector>

#include "posterior/frf/table.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::frf {

/// Immutable: one serves all threads.
class ResponseModel {
 public:
  /// A row's frequency stands for itself, with the g of the harmonics beside it; where its harmonics are known, for so
  /// many neighbouring ones, averaged as sim::FrequencyResponse does, of those the ones whose mean is nearest to it.
  /// Throws Error if the protocol is not valid or of another body model than the single pendulum, if its stimulus has
  /// no frequency response (sim::FrequencyResponse), for a frequency farther than 1 / cycle from each of the stimulus'
  /// harmonics, and for more harmonics than it has.
  ResponseModel(const sim::Protocol& protocol, const Table& table);

  const sim::Protocol& protocol() const noexcept { return protocol_; }
  std::size_t rows() const noexcept { return bands_.size(); }

  /// What a response is derived by, besides the parameters' own names: g is what passes the dead band.
  enum Derivative { by_kp, by_kd, by_kp_pass, by_kd_pass, by_delay, by_passed, derivatives };

  /// The response at each row, and its derivatives where there is room for them: rows() values, and `derivatives` a
  /// row. They mean something if the loop is stable.
  void respond(const sim::Parameters& parameters, std::span<sim::Complex> responses,
               std::span<sim::Complex> derived = {}) const;
  /// How much of the platform's velocity passes the dead band on average over the cycle, as its best multiple; the g of
  /// a ternary sequence.
  double passed_share(double nv, double theta) const;
  /// Whether the closed loop is stable, theta and noise apart: by the one delay at which it oscillates.
  bool is_stable(const sim::Parameters& parameters) const;

 private:
  struct Level {
    double rate_rad_s, share;  // above 0; of the cycle's intervals
  };
  struct Line {  // one frequency
    double frequency_hz, weight;
    sim::Complex forward, backward, body;  // s_f, s_b, J s_f s_b - m g h
  };
  struct Band {  // a row's
    std::vector<Line> lines;
    std::vector<sim::Complex> passing;  // g is the sum of these times m at the levels
  };
  Line line_at(double frequency_hz, double weight) const;

  sim::Protocol protocol_;
  double noise_rad_s_;         // of the noise's velocity at Nv = 1
  std::vector<Level> levels_;  // velocities of the platform
  std::vector<Band> bands_;
};

/// What passes a dead band of threshold theta on average, of a signal and Gaussian noise of this standard deviation.
double mean_passed(double signal, double deviation, double theta);

}  // namespace decid::frf
