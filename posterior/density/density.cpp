// The posterior density of a recorded trial and its gradient: see density.hpp. A forward pass models the sway; the
// backward pass goes through the same steps in reverse.
#include "posterior/density/density.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/text.hpp"
#include "posterior/sampling/detail/chains.hpp"

namespace decid::posterior {

Density::Transforms Density::transforms() const {
  return {fft_.length(), noise_.transform_length(), noise_.transforms()};
}

Density::Workspace::Workspace(const Density& d) {
  const auto of = [](int count) { return static_cast<std::size_t>(count) * lanes; };
  for (auto* values : {&velocity, &by_velocity}) values->assign(of(d.noise_.edges()), 0.0);
  for (auto* values : {&fine, &by_fine}) values->assign(of(2 * d.bins_ + 1), 0.0);
  for (auto* values : {&halves, &by_halves, &by_low, &by_high, &by_theta}) values->assign(of(2 * d.bins_), 0.0);
  for (auto* values : {&passed, &by_passed}) values->assign(of(d.padded_blocks_), 0.0);
  for (auto* values : {&bins_spectrum, &loop_spectrum, &sway_spectrum}) values->assign(of(2 * d.fft_.bins()), 0.0);
  for (auto* values : {&delayed, &inverse, &sway, &observe, &response}) values->assign(of(2 * d.frequencies_), 0.0);
  modelled.assign(of(d.padded_blocks_), 0.0);
  residual.assign(of(d.padded_blocks_), 0.0);
  unfolded.assign(of(d.blocks_), 0.0);
  noise = d.spectrum_.workspace();
  fft_work.assign(of(2 * d.fft_.work_length()), 0.0);
  noise_work.assign(d.noise_.work_size(), 0.0);
}

LoopParameters Density::loop_parameters(const Chains& c) const {
  using enum sim::Coefficient;
  return {.kp = c[kp].data(),
          .kd = c[kd].data(),
          .kp_pass = c[kp_pass].data(),
          .kd_pass = c[kd_pass].data(),
          .gain = c.value[place(Quantity::gain)].data(),
          .delay_first = c.delay_first[0].data(),
          .delay_turn = c.delay_turn[0].data(),
          .start_first = c.start_first[0].data(),
          .start_turn = c.start_turn[0].data(),
          .position = c[position].data(),
          .tilt = c[tilt].data(),
          .gravity = c[gravity].data(),
          .slow = c[slow].data(),
          .torque = c[torque].data()};
}

DeadBandBins Density::halves() const {
  return {2 * bins_, rate_low_.data(), rate_high_.data(), weight_.data()};
}

DeadBandValues Density::dead_band_values(const Chains& c, Workspace& work) const {
  return {work.fine.data(),    c.noise_gain.data(), c[sim::Coefficient::theta].data(),
          work.halves.data(),  work.by_low.data(),  work.by_high.data(),
          work.by_theta.data()};
}

LoopConstants Density::constants(const Observation& observation) const {
  return {frequencies_,          s_.data(),
          sum_.data(),           rate_.data(),
          body_.data(),          hold_.data(),
          observe_.data(),       platform_.data(),
          unbinned_.data(),      observation.torque.data(),
          2.0 / padded_blocks_,  derivative_.data(),
          slow_response_.data(), torque_response_.data()};
}

void Density::check(const Observation& observation, std::span<const double> x, std::size_t results,
                    std::size_t expected) const {
  const auto all = static_cast<std::size_t>(size()) * lanes;
  if (x.size() == all && results == expected && observation.sway.size() == static_cast<std::size_t>(blocks_) &&
      observation.torque.size() == s_.size())
    return;
  throw Error(Code::size_mismatch, "posterior",
              format("got %zu coordinates and space for %zu results", x.size(), results),
              format("give %zu and %zu, and an observation of this density", all, expected));
}

void Density::to_blocks(Workspace& work) const {
  fft_.inverse_lanes(work.sway_spectrum, work.modelled, work.fft_work, isa_);
}

std::array<double, lanes> Density::forward(const Observation& observation, std::span<const double> x, const Chains& c,
                                           Workspace& work) const {
  const Kernels& run = kernels(isa_);
  noise_.synthesize(x.data(), work.velocity.data(), work.noise_work.data(), isa_);
  run.refine(bins_ + 1, work.velocity.data(), work.fine.data());
  run.dead_band(halves(), dead_band_values(c, work));
  run.join(bins_, work.halves.data(), work.passed.data());
  fft_.forward_lanes(work.passed, work.bins_spectrum, work.fft_work, isa_);
  (unit_gains_ ? run.loop : run.family_loop)(constants(observation), loop_parameters(c),
                                             {work.bins_spectrum.data(), work.delayed.data(), work.inverse.data(),
                                              work.sway.data(), work.observe.data(), work.sway_spectrum.data()});
  to_blocks(work);
  run.unfold(blocks_, observation.sway.data(), trial_blocks(work.modelled), undamp_.data(), work.unfolded.data());
  spectrum_.clear(observation.missing, work.unfolded);
  std::array<double, lanes> misfit = spectrum_.misfit(c.levels, work.unfolded, work.noise, isa_);
  spectrum_.leave_out(observation.missing, work.noise, misfit, isa_);
  return misfit;
}

std::array<double, sim::Coefficients::count> Density::by_coefficients(std::span<const double> sums, double by_nv,
                                                                      double by_theta, std::size_t l) const {
  using enum sim::Coefficient;
  std::array<double, sim::Coefficients::count> by{};
  const auto set = [&](sim::Coefficient c, double value) { by[static_cast<std::size_t>(c)] = value; };
  constexpr std::array<std::pair<sim::Coefficient, std::size_t>, 10> of_loop{{{kp, 0},
                                                                              {kd, 1},
                                                                              {kp_pass, 2},
                                                                              {kd_pass, 3},
                                                                              {delay, 4},
                                                                              {position, 7},
                                                                              {tilt, 8},
                                                                              {gravity, 9},
                                                                              {slow, 10},
                                                                              {torque, 11}}};
  for (const auto& [coefficient, sum] : of_loop) set(coefficient, sums[sum * lanes + l]);
  set(nv, by_nv);
  set(theta, by_theta);
  return by;
}

Density::ModelDerivatives Density::backward(const Observation& observation, const Chains& c, std::span<double> gradient,
                                            Workspace& work) const {
  const Kernels& run = kernels(isa_);
  ModelDerivatives d;
  spectrum_.clear(observation.missing, work.unfolded);
  std::fill(work.residual.begin(), work.residual.end(), 0.0);
  run.fold(blocks_, work.unfolded.data(), undamp_.data(),
           work.residual.data() + static_cast<std::ptrdiff_t>(lead_blocks_) * lanes);
  fft_.forward_lanes(work.residual, work.sway_spectrum, work.fft_work, isa_);
  const LoopState state{work.bins_spectrum.data(), work.delayed.data(), work.inverse.data(),
                        work.sway.data(),          work.observe.data(), nullptr};
  (unit_gains_ ? run.loop_gradient : run.family_loop_gradient)(
      constants(observation), loop_parameters(c), state,
      {work.sway_spectrum.data(), work.loop_spectrum.data(), d.loop.data()});
  std::fill(work.sway_spectrum.begin() + 2 * frequencies_ * lanes, work.sway_spectrum.end(), 0.0);
  fft_.inverse_lanes(work.loop_spectrum, work.by_passed, work.fft_work, isa_);
  run.join_gradient(bins_, work.by_passed.data(), work.by_halves.data());
  run.dead_band_gradient(halves(), dead_band_values(c, work),
                         {work.by_halves.data(), work.by_fine.data(), d.gain.data(), d.theta.data()});
  run.refine_gradient(bins_ + 1, work.by_fine.data(), work.by_velocity.data());
  noise_.gradient(work.by_velocity.data(), gradient.data(), work.noise_work.data(), isa_);
  return d;
}

void Density::add_model_gradient(const Chains& c, const ModelDerivatives& d, std::size_t l,
                                 std::span<double> gradient) const {
  const auto add = [&](std::size_t i, double derivative) {
    double& global = gradient[(static_cast<std::size_t>(noise_.size()) + i) * lanes + l];
    global = std::fma(-derivative, c.d_coordinate[i][l], global);
  };
  add(place(start), d.loop[5 * lanes + l]);
  add(place(gain), d.loop[6 * lanes + l]);
  const double back = pass_back();
  const std::array<double, sim::Coefficients::count> by_coefficient =
      by_coefficients(d.loop, back * d.gain[l] * c.d_nv[l], back * d.theta[l], l);
  std::array<double, sim::Parameters::max_parameters> by_parameter{};
  for (const sim::Family::Term& term : family().terms)
    by_parameter[term.parameter] += term.factor * by_coefficient[static_cast<std::size_t>(term.coefficient)];
  for (std::size_t i = 0; i < quantiles_.size(); ++i) add(i, by_parameter[i]);
}

void Density::evaluate(const Observation& observation, std::span<const double> x, std::span<double> gradient,
                       std::span<double> potential, Workspace& work, std::optional<double> fixed_noise_deg) const {
  check(observation, x, gradient.size() + potential.size(), x.size() + lanes);
  const Kernels& run = kernels(isa_);
  const Chains c = chains(x, fixed_noise_deg);
  const std::array<double, lanes> misfit = forward(observation, x, c, work);
  NoiseSpectrum::LevelGradient d_levels = spectrum_.gradient(c.levels, work.unfolded, work.noise, isa_);
  spectrum_.add_gradient(observation.missing, c.levels, work.noise, d_levels, isa_);
  const ModelDerivatives d_model = backward(observation, c, gradient, work);

  const auto noises = static_cast<std::size_t>(noise_.size());
  std::array<double, lanes> coefficient_squares, factor, of_prior;
  for (std::size_t l = 0; l < lanes; ++l) {
    of_prior[l] = 1.0 / (c.radius[l] * c.radius[l]);
    factor[l] = -pass_back() * c.noise_gain[l];
  }
  run.squares(noise_.size(), x.data(), coefficient_squares.data());
  run.with_prior(noise_.size(), factor.data(), of_prior.data(), x.data(), gradient.data());
  for (std::size_t l = 0; l < lanes; ++l) {
    const auto global = [&](std::size_t i) -> double& { return gradient[(noises + i) * lanes + l]; };
    const auto of = [&](int quantity) -> double& { return global(place(quantity)); };
    const double count = static_cast<double>(noises);
    double value = misfit[l] + 0.5 * coefficient_squares[l] * of_prior[l] + count * decid::log(c.radius[l]);
    for (std::size_t i = 0; i < static_cast<std::size_t>(globals()); ++i) {
      const double coordinate = x[(noises + i) * lanes + l];
      value += 0.5 * coordinate * coordinate;
      global(i) = coordinate;
    }
    potential[l] = value;
    add_model_gradient(c, d_model, l, gradient);
    const double nv = c[sim::Coefficient::nv][l];
    if (const std::optional<std::size_t> parameter = family().find_parameter(sim::Coefficient::nv))
      global(*parameter) +=
          (count - coefficient_squares[l] * of_prior[l]) * nv * of_prior[l] * c.d_coordinate[*parameter][l];
    const double d_slow = d_levels.slow[l] * c.levels.slow[l];
    of(sensor_noise) += d_levels.white[l] * c.levels.white[l] * c.d_white[l] + d_slow * c.d_slow_white[l];
    of(slow_noise) += d_slow * c.d_slow[l];
    of(slow_memory) += (d_slow + 2.0 * d_levels.memory[l]) * c.d_memory[l];
  }
}

void Density::model(const Observation& observation, std::span<const double> x, std::span<double> sway_rad,
                    std::span<double> residual_rad, Workspace& work) const {
  check(observation, x, sway_rad.size() + residual_rad.size(), 2 * static_cast<std::size_t>(blocks_) * lanes);
  const Kernels& run = kernels(isa_);
  forward(observation, x, chains(x, {}), work);
  run.scale(blocks_, trial_blocks(work.modelled), undamp_.data(), sway_rad.data());
  const double root = std::sqrt(static_cast<double>(blocks_));
  for (std::size_t m = 0; m < static_cast<std::size_t>(blocks_); ++m) {
    const double place = (static_cast<double>(m) + 0.5) / blocks_ - 0.5;
    const double recorded_line = observation.level_rad + observation.slope_rad * place * blocks_;
    for (std::size_t l = 0; l < lanes; ++l) {
      double& sway = sway_rad[m * lanes + l];
      sway += work.noise.coefficient[l] / root + work.noise.line[l] * place;
      residual_rad[m * lanes + l] = observation.sway[m] - sway;
      sway += recorded_line;
    }
  }
  for (const int m : observation.missing.blocks)
    std::ranges::fill(residual_rad.subspan(static_cast<std::size_t>(m) * lanes, lanes), 0.0);
}

void Density::leave_block_out(const Observation& observation, std::span<const double> x, std::span<double> log_density,
                              Workspace& work) const {
  check(observation, x, log_density.size(), static_cast<std::size_t>(blocks_) * lanes);
  forward(observation, x, chains(x, {}), work);
  spectrum_.leave_block_out(observation.missing, log_density, work.noise, isa_);
  const double per_deg = decid::log(sim::rad_per_deg);
  for (double& value : log_density) value += per_deg;
  for (const int m : observation.missing.blocks)
    std::ranges::fill(log_density.subspan(static_cast<std::size_t>(m) * lanes, lanes), 0.0);
}

}  // namespace decid::posterior
