// Hamiltonian Monte Carlo: see sampler.hpp.
#include "posterior/sampling/sampler.hpp"

#include <algorithm>
#include <cmath>

#include "base/math/cholesky.hpp"
#include "base/math/math.hpp"
#include "posterior/streams.hpp"

namespace decid::posterior {
namespace {

constexpr double divergence = 500.0;  // of the energy
constexpr double lowest_log_step = -12.0, highest_log_step = 1.0;

}  // namespace

Sampler::Sampler(const Density& density, const Observation& observation, std::uint64_t seed, std::uint64_t group)
    : density_(density),
      observation_(observation),
      work_(density),
      random_(seed, streams::chains, group),
      size_(static_cast<std::size_t>(density.size())) {
  for (auto* values : {&x_, &start_, &y_, &momentum_, &gradient_, &force_, &direction_})
    values->assign(size_ * lanes, 0.0);
  metric_.assign(triangle(size_), 0.0);
  for (std::size_t i = 0; i < size_; ++i) metric_[triangle(i) + i] = 1.0;
  begin_adapting(0.1);
}

Sampler::Lanes Sampler::potential(std::span<const double> x) {
  Lanes potential;
  AlignedVector<double> gradient(x.size());
  density_.evaluate(observation_, x, gradient, potential, work_, fixed_noise_deg_);
  return potential;
}

void Sampler::information(std::span<const double> x, std::span<double> matrices) {
  density_.information(observation_, x, matrices, work_, fixed_noise_deg_);
}

bool Sampler::set_metric(std::span<const double> information) {
  std::vector<double> factor(information.begin(), information.end());
  for (std::size_t row = size_ - (holds_ ? Density::held : 0); row < size_; ++row) {
    std::fill_n(factor.begin() + static_cast<std::ptrdiff_t>(triangle(row)), row, 0.0);
    factor[triangle(row) + row] = 1.0;
  }
  AlignedVector<double> work(inverse_work(size_));
  if (!kernels(density_.isa()).inverse_factor(static_cast<int>(size_), factor.data(), work.data())) return false;
  metric_ = std::move(factor);
  return true;
}

void Sampler::begin_adapting(double step) {
  step_.fill(step);
  centre_ = decid::log(5.0 * step);
  mean_log_step_.fill(decid::log(step));
  missing_.fill(0.0);
  adapted_ = 0;
}

void Sampler::adapt(double acceptance) {
  ++adapted_;
  const double weight = 1.0 / (adapted_ + 10.0);
  const double fresh = decid::exp(-0.75 * decid::log(adapted_));
  for (std::size_t l = 0; l < lanes; ++l) {
    missing_[l] = (1.0 - weight) * missing_[l] + weight * (acceptance - acceptance_[l]);
    const double log_step = std::clamp(centre_ - std::sqrt(static_cast<double>(adapted_)) / 0.1 * missing_[l],
                                       lowest_log_step, highest_log_step);
    mean_log_step_[l] = fresh * log_step + (1.0 - fresh) * mean_log_step_[l];
    step_[l] = decid::exp(log_step);
  }
}

void Sampler::end_adapting() {
  for (std::size_t l = 0; l < lanes; ++l) step_[l] = decid::exp(mean_log_step_[l]);
}

double Sampler::middle_step() const {
  Lanes sorted = step_;
  std::sort(sorted.begin(), sorted.end());
  return sorted[lanes / 2];
}

// The metric represents the covariance T^t T, with T its inverse factor. The covariance of the globals comes from T's
// last rows, which are the inverse factor of the globals alone. Points y = T^-t x are round where the metric is right.
double Sampler::widest(std::span<const std::array<double, Density::max_globals>> points) const {
  const auto count = static_cast<std::size_t>(density_.globals());
  using Vector = std::array<double, Density::max_globals>;
  const std::size_t first = size_ - count;
  const auto lower = [&](std::size_t row, std::size_t column) {
    return metric_[triangle(first + row) + first + column];
  };
  std::array<Vector, Density::max_globals> covariance{};
  Vector mean{};
  for (const Vector& point : points)
    for (std::size_t i = 0; i < count; ++i) mean[i] += point[i] / static_cast<double>(points.size());
  for (const Vector& point : points) {
    Vector y;
    for (std::size_t i = count; i-- > 0;) {  // solves T^t y = x, from the last row
      double value = density_.is_held(i) ? 0.0 : point[i] - mean[i];
      for (std::size_t k = i + 1; k < count; ++k) value = std::fma(-lower(k, i), y[k], value);
      y[i] = value / lower(i, i);
    }
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = 0; j < count; ++j)
        covariance[i][j] = std::fma(y[i], y[j] / static_cast<double>(points.size()), covariance[i][j]);
  }
  Vector direction;
  direction.fill(1.0);
  double variance = 0.0;
  for (int iteration = 0; iteration < 50; ++iteration) {
    Vector next{};
    double square = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t j = 0; j < count; ++j) next[i] = std::fma(covariance[i][j], direction[j], next[i]);
      square = std::fma(next[i], next[i], square);
    }
    variance = std::sqrt(square);
    if (!(variance > 0.0)) return 0.0;
    for (std::size_t i = 0; i < count; ++i) direction[i] = next[i] / variance;
  }
  return std::sqrt(variance);
}

void Sampler::clear_held(std::span<double> values) const {
  if (holds_) std::ranges::fill(values.last(std::size_t{Density::held} * lanes), 0.0);
}

// Evaluates at y_, coordinates of the reparameterisation; sets x_.
void Sampler::evaluate() {
  reparameterisation_.to_density(y_, x_, log_volume_, reparameterisation_work_, density_.isa());
  density_.evaluate(observation_, x_, gradient_, potential_, work_, fixed_noise_deg_);
  reparameterisation_.pull_back(y_, gradient_, reparameterisation_work_, density_.isa());
  for (std::size_t l = 0; l < lanes; ++l) potential_[l] -= log_volume_[l];
  clear_held(gradient_);
  kernels(density_.isa()).lower_times(static_cast<int>(size_), metric_.data(), gradient_.data(), force_.data());
  ++leapfrog_steps_;
}

// Moves in coordinates that the metric makes round: x = T^t y for its inverse factor T, so the force is T gradient.
void Sampler::move(int leapfrog_steps) {
  const Kernels& run = kernels(density_.isa());
  random_.fill_normal(momentum_, drawn_);
  clear_held(momentum_);
  drawn_ += momentum_.size();
  Lanes step, half_step, choice;
  for (std::size_t l = 0; l < lanes; ++l) {
    step[l] = step_[l] * random_.uniform(drawn_ + l, 0.8, 1.2);
    half_step[l] = 0.5 * step[l];
    choice[l] = random_.uniform(drawn_ + lanes + l);
  }
  drawn_ += 2 * lanes;
  start_ = x_;
  reparameterisation_.from_density(x_, y_, reparameterisation_work_, density_.isa());
  evaluate();
  const Lanes before = potential_, volume_before = log_volume_;
  Lanes squares;
  run.squares(static_cast<int>(size_), momentum_.data(), squares.data());
  for (std::size_t l = 0; l < lanes; ++l) energy_[l] = before[l] + 0.5 * squares[l];

  const int size = static_cast<int>(size_);
  run.subtract_times(size, half_step.data(), force_.data(), momentum_.data());
  for (int leap = 0; leap < leapfrog_steps; ++leap) {
    run.upper_times(size, metric_.data(), momentum_.data(), direction_.data());
    run.add_times(size, step.data(), direction_.data(), y_.data());
    evaluate();
    run.subtract_times(size, (leap + 1 < leapfrog_steps ? step : half_step).data(), force_.data(), momentum_.data());
  }
  run.squares(size, momentum_.data(), squares.data());
  for (std::size_t l = 0; l < lanes; ++l) {
    const double change = potential_[l] + 0.5 * squares[l] - energy_[l];
    diverged_[l] = !(change < divergence);
    acceptance_[l] = diverged_[l] ? 0.0 : decid::exp(-std::max(0.0, change));
    const bool accepted = choice[l] < acceptance_[l];
    log_density_[l] = accepted ? -potential_[l] - log_volume_[l] : -before[l] - volume_before[l];
    if (accepted) continue;
    for (std::size_t i = 0; i < size_; ++i) x_[i * lanes + l] = start_[i * lanes + l];
    potential_[l] = before[l];
  }
}

}  // namespace decid::posterior
