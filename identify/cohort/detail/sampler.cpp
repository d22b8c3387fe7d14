// The Gibbs sampler's structure, and its draws of standard deviations: see sampler.hpp.
#include "identify/cohort/detail/sampler.hpp"

#include <algorithm>
#include <limits>

#include "base/math/cholesky.hpp"
#include "base/math/math.hpp"
#include "identify/detail/streams.hpp"

namespace decid::cohort {
namespace {

constexpr double lowest_log_sd = -6.907755278982137;  // of 0.001
constexpr double first_low = 0.03, first_high = 0.9;  // chains begin with standard deviations between these
constexpr double factor_sd = 0.3;                     // of the logarithm of a group's standard deviation
constexpr std::size_t everybody = std::numeric_limits<std::size_t>::max();

double squared(double value) {
  return value * value;
}

}  // namespace

Sampler::Sampler(const Design& design, std::span<const Recording> recordings, std::uint64_t seed, std::size_t chain)
    : design_(design),
      recordings_(recordings),
      seed_(seed),
      chain_(chain),
      random_(seed, streams::cohort, chain_ << 32U),
      size_(design.parameters),
      coefficients_(design.cells.size() + design.covariate_sd.size()),
      noise_variance_(size_, 0.0),
      base_(design.visits.size() * size_),
      coefficient_(coefficients_ * size_),
      x_(recordings.size() * size_),
      residual_(recordings.size() * size_),
      of_recording_(recordings.size(), Evidence(size_)),
      of_visit_(design.visits.size(), Evidence(size_)),
      about_base_(design.visits.size(), Evidence(size_)),
      recording_node_(recordings.size(), Deviation(size_)),
      visit_node_(design.visits.size(), Deviation(size_)),
      participant_node_(design.participants.size(), Deviation(size_)),
      sd_(size_),
      location_(size_),
      work_(size_),
      normal_(size_),
      scratch_(size_) {
  const std::array counts{design.participants.size(), design.visits.size(), recordings.size()};
  levels_[participants].active = true;
  levels_[visits].active = design.has_visit_level;
  levels_[trials].active = design.has_trial_level;
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    levels_[l].log_sd.assign(size_, 0.0);
    levels_[l].log_factor.assign(design.groups * size_, 0.0);
    levels_[l].effects.assign(counts[l] * size_, 0.0);
    levels_[l].group.assign(counts[l], 0);
    levels_[l].entity.resize(recordings.size());
  }
  for (std::size_t i = 0; i < design.participants.size(); ++i)
    levels_[participants].group[i] = design.participants[i].group;
  for (std::size_t v = 0; v < design.visits.size(); ++v)
    for (const std::size_t r : design.visits[v].recordings) {
      levels_[participants].entity[r] = design.visits[v].participant;
      levels_[visits].entity[r] = v;
      levels_[trials].entity[r] = r;
    }
  for (std::size_t p = 0; p < size_; ++p) {
    double sum = 0.0;
    for (const Recording& one : recordings) sum += 1.0 / one.measurement.variance(p);
    noise_variance_[p] = static_cast<double>(recordings.size()) / sum;
  }
  for (std::size_t j = 0; j < design.cells.size(); ++j)
    for (std::size_t p = 0; p < size_; ++p) coefficient_[j * size_ + p] = 0.3 * random_.normal(used_++);
  // Far apart, so that R-hat shows a warm-up that is too short.
  for (Level& level : levels_)
    for (double& log_sd : level.log_sd) log_sd = log(first_low) + log(first_high / first_low) * uniform();
  for (std::size_t v = 0; v < design.visits.size(); ++v)
    for (std::size_t p = 0; p < size_; ++p) base_[v * size_ + p] = coefficient_[design.visits[v].cell * size_ + p];
}

std::span<const double> Sampler::normals() {
  for (double& value : normal_) value = random_.normal(used_++);
  return normal_;
}

double Sampler::sd(const Level& level, std::size_t group, std::size_t parameter) const {
  return exp(level.log_sd[parameter] + level.log_factor[group * size_ + parameter]);
}

void Sampler::set_sd(const Level& level, std::size_t group) {
  for (std::size_t p = 0; p < size_; ++p) sd_[p] = sd(level, group, p);
}

void Sampler::sweep() {
  random_ = Random(seed_, streams::cohort, (chain_ << 32U) + ++sweep_);
  used_ = 0;
  for (std::size_t r = 0; r < recordings_.size(); ++r) draw_component(r);
  draw_locations();
  for (Level& level : levels_)
    for (std::size_t p = 0; level.active && p < size_; ++p) scale_centred(level, p);
  set_residuals();
  for (Level& level : levels_)
    for (std::size_t p = 0; level.active && p < size_; ++p) scale_noncentred(level, p);
}

/// Log prior density of the logarithms of one parameter's standard deviations.
double Sampler::log_prior(std::size_t parameter) const {
  double below = noise_variance_[parameter], density = 0.0;
  const auto add = [&](const Level& level) {
    if (!level.active) return;
    const double variance = exp(2.0 * level.log_sd[parameter]);
    density += level.log_sd[parameter] - 0.5 * log(variance + below);
    below += variance;
  };
  add(levels_[trials]);
  below /= design_.recordings_per_visit;
  add(levels_[visits]);
  below /= design_.visits_per_participant;
  add(levels_[participants]);
  return density;
}

double Sampler::slice(double at, double low, double high, const std::function<double(double)>& log_density) {
  const double height = log_density(at) + log(uniform());
  double left = at - uniform(), right = left + 1.0;
  while (left > low && log_density(left) > height) left -= 1.0;
  while (right < high && log_density(right) > height) right += 1.0;
  left = std::max(left, low);
  right = std::min(right, high);
  for (int attempt = 0; attempt < 60; ++attempt) {
    const double value = left + (right - left) * uniform();
    if (log_density(value) > height) return value;
    (value < at ? left : right) = value;
  }
  return at;
}

/// Given the deviations.
void Sampler::scale_centred(Level& level, std::size_t parameter) {
  std::vector<double> squares(design_.groups, 0.0), counts(design_.groups, 0.0);
  for (std::size_t i = 0; i < level.group.size(); ++i) {
    squares[level.group[i]] += squared(level.effects[i * size_ + parameter]);
    counts[level.group[i]] += 1.0;
  }
  double& log_sd = level.log_sd[parameter];
  const auto log_likelihood = [&](std::size_t group) {
    const double log_of_group = log_sd + level.log_factor[group * size_ + parameter];
    return -counts[group] * log_of_group - 0.5 * squares[group] * exp(-2.0 * log_of_group);
  };
  log_sd = slice(log_sd, lowest_log_sd, 0.0, [&](double value) {
    log_sd = value;
    double sum = log_prior(parameter);
    for (std::size_t g = 0; g < design_.groups; ++g)
      if (counts[g] > 0.0) sum += log_likelihood(g);
    return sum;
  });
  if (&level != &levels_[participants] || design_.groups < 2) return;
  for (std::size_t g = 0; g < design_.groups; ++g) {
    double& factor = level.log_factor[g * size_ + parameter];
    factor = slice(factor, -1.5, 1.5, [&](double value) {
      factor = value;
      return log_likelihood(g) - 0.5 * squared(value / factor_sd);
    });
  }
}

/// Multiplies the deviations of a group, and moves the recordings with them.
void Sampler::rescale(Level& level, std::size_t parameter, double factor, std::size_t group) {
  for (std::size_t r = 0; r < recordings_.size(); ++r) {
    const std::size_t entity = level.entity[r];
    if (group != everybody && level.group[entity] != group) continue;
    const double step = (factor - 1.0) * level.effects[entity * size_ + parameter];
    x_[r * size_ + parameter] += step;
    const std::span<const double> precision = of_recording_[r].precision;
    for (std::size_t q = 0; q < size_; ++q)
      residual_[r * size_ + q] -= step * precision[triangle(std::max(q, parameter)) + std::min(q, parameter)];
  }
  for (std::size_t i = 0; i < level.group.size(); ++i)
    if (group == everybody || level.group[i] == group) level.effects[i * size_ + parameter] *= factor;
}

/// Given the deviations over their standard deviations: a factor moves all recordings.
void Sampler::scale_noncentred(Level& level, std::size_t parameter) {
  const auto move = [&](double& log_value, double low, double high, std::size_t group, const auto& log_density) {
    double by_factor = 0.0, curvature = 0.0;
    for (std::size_t r = 0; r < recordings_.size(); ++r) {
      const std::size_t entity = level.entity[r];
      if (group != everybody && level.group[entity] != group) continue;
      const double d = level.effects[entity * size_ + parameter];
      by_factor += residual_[r * size_ + parameter] * d;
      curvature += of_recording_[r].precision[triangle(parameter) + parameter] * d * d;
    }
    const double before = log_value;
    log_value = slice(before, low, high, [&](double value) {
      log_value = value;
      const double step = exp(value - before) - 1.0;
      return log_density(value) + by_factor * step - 0.5 * curvature * step * step;
    });
    rescale(level, parameter, exp(log_value - before), group);
  };
  move(level.log_sd[parameter], lowest_log_sd, 0.0, everybody, [&](double) { return log_prior(parameter); });
  if (&level != &levels_[participants] || design_.groups < 2) return;
  for (std::size_t g = 0; g < design_.groups; ++g)
    move(level.log_factor[g * size_ + parameter], -1.5, 1.5, g,
         [](double value) { return -0.5 * squared(value / factor_sd); });
}

Draw Sampler::draw() const {
  const std::size_t cells = design_.cells.size() * size_;
  Draw draw;
  draw.cell_mean.assign(coefficient_.begin(), coefficient_.begin() + static_cast<std::ptrdiff_t>(cells));
  draw.slopes.assign(coefficient_.begin() + static_cast<std::ptrdiff_t>(cells), coefficient_.end());
  for (std::size_t g = 0; g < design_.groups; ++g)
    for (std::size_t p = 0; p < size_; ++p) draw.participant_sd.push_back(sd(levels_[participants], g, p));
  for (std::size_t p = 0; p < size_; ++p) {
    if (levels_[visits].active) draw.visit_sd.push_back(exp(levels_[visits].log_sd[p]));
    if (levels_[trials].active) draw.trial_sd.push_back(exp(levels_[trials].log_sd[p]));
  }
  for (std::size_t v = 0; v < design_.visits.size(); ++v)
    for (std::size_t p = 0; p < size_; ++p) {
      double value = base_[v * size_ + p] + levels_[participants].effects[design_.visits[v].participant * size_ + p];
      if (levels_[visits].active) value += levels_[visits].effects[v * size_ + p];
      draw.visits.push_back(value);
    }
  return draw;
}

}  // namespace decid::cohort
