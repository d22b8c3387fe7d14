// The Gibbs sampler's draws of components, means, participants, visits and trials: see sampler.hpp.
#include <algorithm>

#include "base/error.hpp"
#include "base/math/cholesky.hpp"
#include "base/math/math.hpp"
#include "identify/cohort/detail/sampler.hpp"

namespace decid::cohort {
namespace {

constexpr double slope_sd = 0.5;  // prior, of a covariate's effect per standard deviation

}  // namespace

/// Sets sd_ to the standard deviations of the lowest level above a recording, and location_ to the place that it
/// deviates from.
void Sampler::set_location_above(std::size_t recording) {
  const std::size_t visit = levels_[visits].entity[recording], participant = levels_[participants].entity[recording];
  for (std::size_t p = 0; p < size_; ++p) {
    location_[p] = base_[visit * size_ + p];
    if (levels_[trials].active || levels_[visits].active)
      location_[p] += levels_[participants].effects[participant * size_ + p];
    if (levels_[trials].active && levels_[visits].active) location_[p] += levels_[visits].effects[visit * size_ + p];
  }
  if (levels_[trials].active || levels_[visits].active)
    set_sd(levels_[levels_[trials].active ? trials : visits], 0);
  else
    set_sd(levels_[participants], levels_[participants].group[participant]);
}

/// Sets evidence to a component's precision less the prior's 1.
void Sampler::set_precision(const Measurement& measurement, std::size_t component, Evidence& evidence) const {
  const std::span<const double> precision = measurement.precision(component);
  evidence.precision.assign(precision.begin(), precision.end());
  for (std::size_t p = 0; p < size_; ++p) evidence.precision[triangle(p) + p] -= 1.0;
}

/// Returns the log weight of a component with precision P: |L^-1 (P c + a)|^2 / 2 - c.P c / 2, and the node's
/// determinant, where a is the location over the variance.
double Sampler::weigh(const Measurement& measurement, std::size_t component, const Deviation& node) {
  const std::span<const double> precision = measurement.precision(component);
  for (std::size_t p = 0; p < size_; ++p) work_[p] = measurement.centre(component, p);
  double sum = measurement.log_weight(component) + node.log_root_determinant();
  for (std::size_t p = 0; p < size_; ++p) {
    const double by = row_times(precision, p, work_);
    sum -= 0.5 * by * work_[p];
    scratch_.shift[p] = by + location_[p];
  }
  node.whiten(scratch_.shift, work_);
  for (const double value : work_) sum += 0.5 * value * value;
  return sum;
}

/// Draws the component given the location that the recording deviates from.
void Sampler::draw_component(std::size_t recording) {
  const Measurement& measurement = recordings_[recording].measurement;
  const std::size_t count = measurement.components();
  Evidence& evidence = of_recording_[recording];
  Deviation& node = recording_node_[recording];
  set_location_above(recording);
  for (std::size_t p = 0; p < size_; ++p) location_[p] /= sd_[p] * sd_[p];
  log_weights_.resize(count);
  for (std::size_t k = 0; k < count; ++k) {
    set_precision(measurement, k, evidence);
    node.prepare(sd_, evidence);
    log_weights_[k] = weigh(measurement, k, node);
  }

  const double highest = *std::ranges::max_element(log_weights_);
  double whole = 0.0;
  for (double& value : log_weights_) whole += value = exp(value - highest);
  double left = whole * uniform();
  std::size_t chosen = 0;
  while (chosen + 1 < count && (left -= log_weights_[chosen]) > 0.0) ++chosen;

  set_precision(measurement, chosen, evidence);
  for (std::size_t p = 0; p < size_; ++p) work_[p] = measurement.centre(chosen, p);
  for (std::size_t p = 0; p < size_; ++p) evidence.shift[p] = row_times(measurement.precision(chosen), p, work_);
}

/// Passes the evidence of recordings up to the means, draws these, and then everything below them.
void Sampler::draw_locations() {
  const std::size_t order = coefficients_ * size_;
  matrix_.assign(triangle(order), 0.0);
  right_.assign(order, 0.0);
  for (std::size_t i = 0; i < order; ++i)
    matrix_[triangle(i) + i] = i < design_.cells.size() * size_ ? 1.0 : 1.0 / (slope_sd * slope_sd);
  for (std::size_t v = 0; v < design_.visits.size(); ++v) {
    of_visit_[v].clear();
    set_sd(levels_[trials], 0);
    for (const std::size_t r : design_.visits[v].recordings) {
      if (levels_[trials].active) recording_node_[r].absorb(sd_, of_recording_[r], scratch_);
      of_visit_[v].add(levels_[trials].active ? scratch_ : of_recording_[r]);
    }
    set_sd(levels_[visits], 0);
    if (levels_[visits].active)
      visit_node_[v].absorb(sd_, of_visit_[v], about_base_[v]);
    else
      about_base_[v] = of_visit_[v];
  }
  for (std::size_t i = 0; i < design_.participants.size(); ++i) absorb_participant(i);
  draw_coefficients();
  draw_effects();
}

/// Adds a person's evidence about the means: of all visits together, with the person's deviation integrated out.
void Sampler::absorb_participant(std::size_t participant) {
  const Design::Participant& one = design_.participants[participant];
  Deviation& node = participant_node_[participant];
  scratch_.clear();
  for (const std::size_t v : one.visits) scratch_.add(about_base_[v]);
  set_sd(levels_[participants], one.group);
  node.prepare(sd_, scratch_);
  node.whiten(scratch_.shift, work_);
  std::vector<std::vector<double>> whitened(one.visits.size(), std::vector<double>(size_ * size_));
  for (std::size_t a = 0; a < one.visits.size(); ++a) node.whiten(about_base_[one.visits[a]], whitened[a]);

  const std::size_t cells = design_.cells.size();
  const auto weight = [&](const Design::Visit& visit, std::size_t j) {
    return j < cells ? (visit.cell == j ? 1.0 : 0.0) : visit.covariates[j - cells];
  };
  for (std::size_t a = 0; a < one.visits.size(); ++a) {
    const Design::Visit& visit = design_.visits[one.visits[a]];
    const Evidence& evidence = about_base_[one.visits[a]];
    for (std::size_t p = 0; p < size_; ++p) {
      double shift = evidence.shift[p];
      for (std::size_t k = 0; k < size_; ++k) shift -= whitened[a][k * size_ + p] * work_[k];
      for (std::size_t j = 0; j < coefficients_; ++j) right_[j * size_ + p] += weight(visit, j) * shift;
    }
    for (std::size_t b = 0; b < one.visits.size(); ++b) {
      const Design::Visit& other = design_.visits[one.visits[b]];
      for (std::size_t p = 0; p < size_; ++p)
        for (std::size_t q = 0; q < size_; ++q) {
          double block = a == b ? evidence.precision[triangle(std::max(p, q)) + std::min(p, q)] : 0.0;
          for (std::size_t k = 0; k < size_; ++k) block -= whitened[a][k * size_ + p] * whitened[b][k * size_ + q];
          for (std::size_t i = 0; i < coefficients_; ++i) {
            const double factor = weight(visit, i);
            if (factor == 0.0) continue;
            for (std::size_t j = 0; j < coefficients_; ++j)
              if (const std::size_t row = i * size_ + p, column = j * size_ + q; column <= row)
                matrix_[triangle(row) + column] += factor * weight(other, j) * block;
          }
        }
    }
  }
}

void Sampler::draw_coefficients() {
  const std::size_t order = coefficients_ * size_;
  if (!factorize(order, matrix_))
    throw Error(Code::value_invalid, "cohort", "the evidence of the recordings is not finite",
                "leave out recordings that are not usable");
  invert_lower(order, matrix_);
  std::vector<double> whitened(order, 0.0);
  for (std::size_t i = 0; i < order; ++i) {
    for (std::size_t k = 0; k <= i; ++k) whitened[i] += matrix_[triangle(i) + k] * right_[k];
    whitened[i] += random_.normal(used_++);
  }
  for (std::size_t i = 0; i < order; ++i) {
    coefficient_[i] = 0.0;
    for (std::size_t k = i; k < order; ++k) coefficient_[i] += matrix_[triangle(k) + i] * whitened[k];
  }
  const std::size_t cells = design_.cells.size();
  for (std::size_t v = 0; v < design_.visits.size(); ++v)
    for (std::size_t p = 0; p < size_; ++p) {
      double value = coefficient_[design_.visits[v].cell * size_ + p];
      for (std::size_t j = cells; j < coefficients_; ++j)
        value += design_.visits[v].covariates[j - cells] * coefficient_[j * size_ + p];
      base_[v * size_ + p] = value;
    }
}

/// Draws participants, then visits, then recordings, each given its location.
void Sampler::draw_effects() {
  for (std::size_t i = 0; i < design_.participants.size(); ++i) {
    std::ranges::fill(work_, 0.0);
    for (const std::size_t v : design_.participants[i].visits)
      for (std::size_t p = 0; p < size_; ++p)
        work_[p] += about_base_[v].shift[p] - row_times(about_base_[v].precision, p, of(base_, v));
    participant_node_[i].draw(work_, normals(), of(levels_[participants].effects, i));
  }
  for (std::size_t v = 0; v < design_.visits.size(); ++v) {
    const std::span<double> own = of(levels_[visits].effects, v);
    for (std::size_t p = 0; p < size_; ++p)
      location_[p] = base_[v * size_ + p] + levels_[participants].effects[design_.visits[v].participant * size_ + p];
    if (levels_[visits].active) {
      for (std::size_t p = 0; p < size_; ++p)
        work_[p] = of_visit_[v].shift[p] - row_times(of_visit_[v].precision, p, location_);
      visit_node_[v].draw(work_, normals(), own);
      for (std::size_t p = 0; p < size_; ++p) location_[p] += own[p];
    }
    for (const std::size_t r : design_.visits[v].recordings) {
      const std::span<double> x = of(x_, r), effect = of(levels_[trials].effects, r);
      if (levels_[trials].active) {
        for (std::size_t p = 0; p < size_; ++p)
          work_[p] = of_recording_[r].shift[p] - row_times(of_recording_[r].precision, p, location_);
        recording_node_[r].draw(work_, normals(), effect);
      }
      for (std::size_t p = 0; p < size_; ++p) x[p] = location_[p] + effect[p];
    }
  }
}

void Sampler::set_residuals() {
  for (std::size_t r = 0; r < recordings_.size(); ++r)
    for (std::size_t p = 0; p < size_; ++p)
      residual_[r * size_ + p] = of_recording_[r].shift[p] - row_times(of_recording_[r].precision, p, of(x_, r));
}

}  // namespace decid::cohort
