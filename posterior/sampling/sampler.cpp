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

Sampler::Part::Part(const Density& density, std::size_t rows) : work(density) {
  const auto size = static_cast<std::size_t>(density.size());
  for (auto* values : {&x, &start, &y, &gradient, &direction}) values->assign(size * lanes, 0.0);
  for (auto* values : {&momentum, &by_row, &force, &change}) values->assign(rows * lanes, 0.0);
  metric.assign(triangle(rows), 0.0);
  for (std::size_t i = 0; i < rows; ++i) metric[triangle(i) + i] = 1.0;
}

Sampler::Sampler(Target target, std::uint64_t seed, std::uint64_t group)
    : target_(std::move(target)), isa_(target_.density(0).isa()), random_(seed, streams::chains, group) {
  for (std::size_t t = 0; t < target_.trials(); ++t) parts_.emplace_back(target_.density(t), target_.rows(t));
  begin_adapting(0.1);
}

Sampler::Lanes Sampler::potential(std::span<const double> x, std::size_t trial) {
  Lanes potential;
  AlignedVector<double> gradient(x.size());
  Part& part = parts_[trial];
  target_.density(trial).evaluate(target_.observation(trial), x, gradient, potential, part.work, part.fixed_noise_deg);
  target_.count_once(trial, x, gradient, potential);
  return potential;
}

void Sampler::information(std::span<const double> x, std::span<double> matrices, std::size_t trial) {
  Part& part = parts_[trial];
  target_.density(trial).information(target_.observation(trial), x, matrices, part.work, part.fixed_noise_deg);
}

bool Sampler::set_metric(std::span<const std::vector<double>> informations) {
  if (target_.joint()) {
    std::vector<std::vector<double>> metrics;
    if (!target_.metric(informations, holds_ ? Density::held : 0, metrics)) return false;
    for (std::size_t t = 0; t < parts_.size(); ++t) parts_[t].metric = std::move(metrics[t]);
    return true;
  }
  const std::size_t size = target_.rows(0);
  std::vector<double> factor = informations.front();
  for (std::size_t row = size - (holds_ ? Density::held : 0); row < size; ++row) {
    std::fill_n(factor.begin() + static_cast<std::ptrdiff_t>(triangle(row)), row, 0.0);
    factor[triangle(row) + row] = 1.0;
  }
  AlignedVector<double> work(inverse_work(size));
  if (!kernels(isa_).inverse_factor(static_cast<int>(size), factor.data(), work.data())) return false;
  parts_.front().metric = std::move(factor);
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

/// Returns the rows and columns of the globals in the metric's inverse factor, in the order of
/// Target::append_globals(). The trials' own ones do not depend on each other.
std::vector<double> Sampler::metric_of_globals() const {
  std::vector<double> all(triangle(target_.globals()), 0.0);
  std::size_t first = 0;
  for (std::size_t t = 0; t < parts_.size(); ++t) {
    const std::size_t count = target_.own_globals(t), begin = target_.own(t) - count;
    const std::size_t common = target_.globals() - target_.commons();
    for (std::size_t row = 0; row < count + target_.commons(); ++row) {
      const std::size_t to = row < count ? first + row : common + row - count;
      for (std::size_t column = 0; column <= row; ++column)
        all[triangle(to) + (column < count ? first + column : common + column - count)] =
            parts_[t].metric[triangle(begin + row) + begin + column];
    }
    first += count;
  }
  return all;
}

// The metric represents the covariance T^t T, with T its inverse factor. The covariance of the globals comes from T's
// rows of globals, which are the inverse factor of the globals alone. Points y = T^-t x are round where the metric is
// right.
double Sampler::widest(std::span<const std::vector<double>> points) const {
  const std::size_t count = target_.globals();
  using Vector = std::vector<double>;
  const std::vector<double> factor = metric_of_globals();
  const auto lower = [&](std::size_t row, std::size_t column) { return factor[triangle(row) + column]; };
  std::vector<bool> held;
  for (std::size_t t = 0; t < parts_.size(); ++t) {
    held.resize(held.size() + target_.own_globals(t), false);
    std::fill_n(held.rbegin(), Density::held, true);
  }
  held.resize(count, false);
  std::vector<Vector> covariance(count, Vector(count, 0.0));
  Vector mean(count, 0.0);
  for (const Vector& point : points)
    for (std::size_t i = 0; i < count; ++i) mean[i] += point[i] / static_cast<double>(points.size());
  Vector y(count);
  for (const Vector& point : points) {
    for (std::size_t i = count; i-- > 0;) {  // solves T^t y = x, from the last row
      double value = held[i] ? 0.0 : point[i] - mean[i];
      for (std::size_t k = i + 1; k < count; ++k) value = std::fma(-lower(k, i), y[k], value);
      y[i] = value / lower(i, i);
    }
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = 0; j < count; ++j)
        covariance[i][j] = std::fma(y[i], y[j] / static_cast<double>(points.size()), covariance[i][j]);
  }
  Vector direction(count, 1.0);
  double variance = 0.0;
  for (int iteration = 0; iteration < 50; ++iteration) {
    Vector next(count, 0.0);
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

void Sampler::clear_held(std::size_t trial, std::span<double> values) const {
  if (holds_) std::ranges::fill(values.subspan(held_of(trial) * lanes, std::size_t{Density::held} * lanes), 0.0);
}

// Evaluates at y, coordinates of the reparameterisations; sets x.
void Sampler::evaluate() {
  potential_.fill(0.0);
  log_volume_.fill(0.0);
  for (std::size_t t = 0; t < parts_.size(); ++t) {
    Part& part = parts_[t];
    Lanes log_volume, potential;
    part.reparameterisation.to_density(part.y, part.x, log_volume, part.reparameterisation_work, isa_);
    target_.density(t).evaluate(target_.observation(t), part.x, part.gradient, potential, part.work,
                                part.fixed_noise_deg);
    part.reparameterisation.pull_back(part.y, part.gradient, part.reparameterisation_work, isa_);
    target_.count_once(t, part.x, part.gradient, potential);
    for (std::size_t l = 0; l < lanes; ++l) {
      potential_[l] += potential[l] - log_volume[l];
      log_volume_[l] += log_volume[l];
    }
    target_.to_rows(t, part.gradient, part.by_row);
    clear_held(t, part.by_row);
    kernels(isa_).lower_times(static_cast<int>(target_.rows(t)), part.metric.data(), part.by_row.data(),
                              part.force.data());
  }
  add_forces();
  ++leapfrog_steps_;
}

/// Adds the forces on common unknowns, trial by trial.
void Sampler::add_forces() {
  const std::size_t count = target_.commons() * lanes;
  const auto common_of = [count](Part& part) { return std::span(part.force).last(count); };
  for (std::size_t t = 1; t < parts_.size(); ++t)
    std::ranges::transform(common_of(parts_.front()), common_of(parts_[t]), common_of(parts_.front()).begin(),
                           std::plus());
  for (std::size_t t = 1; t < parts_.size(); ++t)
    std::ranges::copy(common_of(parts_.front()), common_of(parts_[t]).begin());
}

/// Draws each trial's white noise given all else; not while it is fixed.
void Sampler::draw_white_noise() {
  std::array<double, Density::white_noise_draws * lanes> normals, uniforms;
  for (std::size_t t = 0; t < parts_.size(); ++t) {
    if (parts_[t].fixed_noise_deg) continue;
    random_.fill_normal(normals, drawn_);
    drawn_ += normals.size();
    for (double& uniform : uniforms) uniform = random_.uniform(drawn_++);
    target_.density(t).draw_white_noise(target_.observation(t), parts_[t].x, normals, uniforms, parts_[t].work);
  }
}

/// Draws the momentum; that of common unknowns with the first trial's.
void Sampler::draw_momentum() {
  const std::size_t common = target_.commons() * lanes;
  for (std::size_t t = 0; t < parts_.size(); ++t) {
    const std::span<double> momentum = parts_[t].momentum;
    const std::span<double> drawn = t == 0 ? momentum : momentum.first(momentum.size() - common);
    random_.fill_normal(drawn, drawn_);
    drawn_ += drawn.size();
    std::ranges::copy(std::span(parts_.front().momentum).last(common), momentum.last(common).begin());
    clear_held(t, momentum);
  }
}

Sampler::Lanes Sampler::kinetic_energy() const {
  Lanes sums{};
  for (std::size_t t = 0; t < parts_.size(); ++t) {
    Lanes squares;
    kernels(isa_).squares(static_cast<int>(t == 0 ? target_.rows(t) : target_.own(t)), parts_[t].momentum.data(),
                          squares.data());
    for (std::size_t l = 0; l < lanes; ++l) sums[l] += 0.5 * squares[l];
  }
  return sums;
}

/// Moves y by the momentum.
void Sampler::advance(Part& part, std::size_t trial, const Lanes& step) {
  const Kernels& run = kernels(isa_);
  run.upper_times(static_cast<int>(target_.rows(trial)), part.metric.data(), part.momentum.data(), part.change.data());
  target_.from_rows(trial, part.change, part.direction);
  run.add_times(target_.density(trial).size(), step.data(), part.direction.data(), part.y.data());
}

// Moves in coordinates that the metric makes round: x = T^t y for its inverse factor T, so the force is T gradient.
void Sampler::move(int leapfrog_steps) {
  draw_white_noise();
  draw_momentum();
  Lanes step, half_step, choice;
  for (std::size_t l = 0; l < lanes; ++l) {
    step[l] = step_[l] * random_.uniform(drawn_ + l, 0.8, 1.2);
    half_step[l] = 0.5 * step[l];
    choice[l] = random_.uniform(drawn_ + lanes + l);
  }
  drawn_ += 2 * lanes;
  for (Part& part : parts_) {
    part.start = part.x;
    part.reparameterisation.from_density(part.x, part.y, part.reparameterisation_work, isa_);
  }
  evaluate();
  const Lanes before = potential_, volume_before = log_volume_, kinetic = kinetic_energy();
  for (std::size_t l = 0; l < lanes; ++l) energy_[l] = before[l] + kinetic[l];

  const auto push = [&](const Lanes& by) {
    for (Part& part : parts_)
      kernels(isa_).subtract_times(static_cast<int>(part.momentum.size() / lanes), by.data(), part.force.data(),
                                   part.momentum.data());
  };
  push(half_step);
  for (int leap = 0; leap < leapfrog_steps; ++leap) {
    for (std::size_t t = 0; t < parts_.size(); ++t) advance(parts_[t], t, step);
    evaluate();
    push(leap + 1 < leapfrog_steps ? step : half_step);
  }
  const Lanes kinetic_after = kinetic_energy();
  for (std::size_t l = 0; l < lanes; ++l) {
    const double change = potential_[l] + kinetic_after[l] - energy_[l];
    // While chains draw, a large gain is an error of the steps, too; to reject both keeps the distribution.
    diverged_[l] = !((holds_ ? std::abs(change) : change) < divergence);
    acceptance_[l] = diverged_[l] ? 0.0 : decid::exp(-std::max(0.0, change));
    const bool accepted = choice[l] < acceptance_[l];
    log_density_[l] = accepted ? -potential_[l] - log_volume_[l] : -before[l] - volume_before[l];
    if (accepted) continue;
    for (Part& part : parts_)
      for (std::size_t i = l; i < part.x.size(); i += lanes) part.x[i] = part.start[i];
    potential_[l] = before[l];
  }
}

}  // namespace decid::posterior
