// A trial: see simulate.hpp for the equations and the choices made where the paper is ambiguous.
#include "sim/simulate.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/parallel.hpp"
#include "sim/detail/controller.hpp"
#include "sim/lanes.hpp"

namespace decid::sim {

std::size_t Outcome::samples(double rate_hz) const {
  return static_cast<std::size_t>(std::floor(end_s * rate_hz + 0.5));
}

/// Lanes kept for the next call: their memory is large, and allocating it takes longer than a trial.
struct Simulator::Core {
  Core(Protocol of_trial, Isa isa)
      : protocol(checked(std::move(of_trial))),
        setup(protocol.with_time_before(), isa),
        samples(protocol.samples()),
        standing(setup.samples - samples) {
    if (standing > 0) own_stimulus = make_stimulus(protocol.experiment);
  }

  const Stimulus& stimulus() const { return own_stimulus ? *own_stimulus : setup.stimulus; }

  /// Wraps `finished` to receive only the part of a trial after the standing.
  Finished after_standing(const Finished& finished) const {
    return [this, &finished](int index, Outcome outcome, std::span<double> sway_rad) {
      const double rate_hz = protocol.experiment.sample_rate_hz;
      const int done = static_cast<int>(outcome.samples(rate_hz));
      outcome.end_s = std::max(0, done - standing) / rate_hz;
      finished(index, outcome, sway_rad.last(static_cast<std::size_t>(samples)));
    };
  }

  /// Runs on lanes that no other thread uses.
  void run(const std::function<int()>& next, const TrialOf& make_trial, const Finished& finished) {
    std::unique_ptr<Lanes> lanes;
    {
      const std::lock_guard lock(mutex);
      if (!idle.empty()) {
        lanes = std::move(idle.back());
        idle.pop_back();
      }
    }
    if (lanes == nullptr) lanes = std::make_unique<Lanes>(setup);
    if (standing > 0)
      lanes->run(next, make_trial, after_standing(finished));
    else
      lanes->run(next, make_trial, finished);
    const std::lock_guard lock(mutex);
    idle.push_back(std::move(lanes));
  }

  Protocol protocol;
  Setup setup;  // of everything that is simulated
  int samples;
  int standing;  // samples before the trial's first
  std::optional<Stimulus> own_stimulus;
  std::mutex mutex;
  std::vector<std::unique_ptr<Lanes>> idle;
};

Simulator::Simulator(Protocol protocol, Isa isa) : core_(std::make_shared<Core>(std::move(protocol), isa)) {}

const Protocol& Simulator::protocol() const noexcept {
  return core_->protocol;
}
const Stimulus& Simulator::stimulus() const noexcept {
  return core_->stimulus();
}
int Simulator::samples() const noexcept {
  return core_->samples;
}

Outcome Simulator::run(const Parameters& parameters, const Random& noise, std::span<double> sway_rad) const {
  if (sway_rad.size() != static_cast<std::size_t>(samples())) {
    throw Error(Code::size_mismatch, "simulation",
                "the output has space for " + std::to_string(sway_rad.size()) + " samples",
                "give space for " + std::to_string(samples()));
  }
  Outcome result{};
  bool taken = false;
  const auto next = [&] { return std::exchange(taken, true) ? -1 : 0; };
  core_->run(
      next,
      [&](int) {
        return TrialInput{parameters, noise};
      },
      [&](int, const Outcome& outcome, std::span<double> sway) {
        result = outcome;
        std::copy_n(sway.begin(), result.samples(protocol().experiment.sample_rate_hz), sway_rad.begin());
      });
  return result;
}

namespace {

/// Distributes indices 0 .. count - 1 to many threads; returns a negative index when none is left.
class Indices {
 public:
  explicit Indices(int count) : count_(count) {}
  int next() {
    if (first_.load(std::memory_order_relaxed) >= count_) return -1;
    const int index = first_.fetch_add(1);
    return index < count_ ? index : -1;
  }
  /// Any thread with a free lane takes a trial; a thread is worth starting for a few of them.
  int threads() const { return std::min(thread_count(), (count_ + 7) / 8); }

 private:
  int count_;
  std::atomic<int> first_{0};
};

}  // namespace

void Simulator::run_all(int count, const TrialOf& make_trial, const Finished& finished) const {
  Indices indices(count);
  parallel_for(indices.threads(), [&](int) { core_->run([&] { return indices.next(); }, make_trial, finished); });
}

void Simulator::run_until_valid(int count, int attempts, const AttemptOf& make_trial, const Valid& finished) const {
  Indices indices(count);
  std::vector<int> attempt(static_cast<std::size_t>(count), 0);
  std::vector<std::optional<TrialInput>> trials(static_cast<std::size_t>(count));
  parallel_for(indices.threads(), [&](int) {
    std::vector<int> again;  // trials that fell in this thread's lanes stay in this thread
    const auto next = [&] {
      if (again.empty()) return indices.next();
      const int index = again.back();
      again.pop_back();
      return index;
    };
    core_->run(
        next,
        [&](int index) {
          const auto i = static_cast<std::size_t>(index);
          trials[i] = make_trial(index, attempt[i]++);
          return *trials[i];
        },
        [&](int index, const Outcome& outcome, std::span<double> sway) {
          const auto i = static_cast<std::size_t>(index);
          if (outcome.valid) return finished(index, *trials[i], sway);
          if (attempt[i] == attempts) {
            throw Error(Code::body_falls, "protocol " + protocol().name,
                        std::to_string(attempts) + " consecutive trials exceed 5 degrees",
                        "reduce the tilt's amplitude or the noise, or give parameters with which the body stands");
          }
          again.push_back(index);
        });
  });
}

namespace {

/// Returns a / b without the library's care for infinities.
Complex over(Complex a, Complex b) {
  const double norm = b.real() * b.real() + b.imag() * b.imag();
  return {(a.real() * b.real() + a.imag() * b.imag()) / norm, (a.imag() * b.real() - a.real() * b.imag()) / norm};
}

}  // namespace

Complex closed_loop(const Experiment& experiment, const Parameters& parameters, double frequency_hz) {
  using enum Coefficient;
  const Family& family = experiment.family();
  const Coefficients of = family.coefficients(parameters);
  const Body& body = experiment.body;
  // exp(-s delay) has the phase frequency * delay, in turns; whole turns cancel.
  const auto [sin, cos] = sincos_of_turns(frequency_hz * of[delay]);
  const double omega = 2.0 * pi * frequency_hz;
  const Complex passive{of[kp_pass], omega * of[kd_pass]};
  // (kp + s kd) (cos - i sin)
  const double omega_kd = omega * of[kd];
  const Complex active{of[kp] * cos + omega_kd * sin, omega_kd * cos - of[kp] * sin};
  const Complex slow_response = over(of[slow], {1.0 / family.slow_time_s, omega});
  const Complex torque_response = over(of[torque] / body.mgh(), {1.0 / family.torque_time_s, omega});
  const Complex loop = over(active, 1.0 - active * torque_response);
  const Complex returned = loop * (of[position] + of[gravity] + slow_response);
  const Complex drive = passive + loop * (of[position] - of[tilt]);
  const Complex d{-body.inertia_kgm2 * omega * omega - body.mgh() + returned.real() + passive.real(),
                  returned.imag() + passive.imag()};
  return over(drive, d);
}

}  // namespace decid::sim
