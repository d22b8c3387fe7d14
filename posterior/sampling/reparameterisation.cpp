// Coordinates in which the posterior is nearly Gaussian: see reparameterisation.hpp.
#include "posterior/sampling/reparameterisation.hpp"

#include <algorithm>
#include <cmath>

#include "base/math/cholesky.hpp"
#include "base/math/math.hpp"
#include "posterior/kernels/kernels.hpp"

namespace decid::posterior {

// The scaled value of a variable is its fraction of its range, minus `middle`, over `scale`.
void Reparameterisation::scale(std::span<const double> x, Workspace& work) const {
  work.z.resize(variables());
  work.slope.resize(variables());
  for (std::size_t a = 0; a < variables(); ++a) {
    const double* values = x.data() + (noises_ + variable_[a]) * lanes;
    for (std::size_t l = 0; l < lanes; ++l) {
      work.z[a][l] = (normal_distribution(values[l]) - middle_[a]) / scale_[a];
      work.slope[a][l] = normal_density(values[l]) / scale_[a];
    }
  }
}

// Features: 1, each variable, each product of two.
void Reparameterisation::widths(std::span<const double> x, Workspace& work, Isa isa) const {
  const auto size = static_cast<int>(noises_);
  scale(x, work);
  work.features.clear();
  work.features.resize(lanes, 1.0);
  for (const Lanes& z : work.z) work.features.insert(work.features.end(), z.begin(), z.end());
  for (std::size_t a = 0; a < variables(); ++a)
    for (std::size_t b = 0; b <= a; ++b)
      for (std::size_t l = 0; l < lanes; ++l) work.features.push_back(work.z[a][l] * work.z[b][l]);
  work.root.assign(noises_ * lanes, 4.0);
  work.cube.resize(noises_ * lanes);
  kernels(isa).add_matrix_times(size, static_cast<int>(variables()), width_by_coefficient_.data(),
                                work.features.data() + lanes, work.root.data());
}

void Reparameterisation::to_density(std::span<const double> y, std::span<double> x, Lanes& log_volume, Workspace& work,
                                    Isa isa) const {
  std::copy(y.begin(), y.end(), x.begin());
  log_volume.fill(0.0);
  if (empty()) return;
  const Kernels& run = kernels(isa);
  widths(y, work, isa);
  run.stretch(static_cast<int>(noises_), work.root.data(), work.cube.data(), x.data(), log_volume.data());
  run.add_matrix_times(static_cast<int>(noises_), static_cast<int>(features()), shift_by_coefficient_.data(),
                       work.features.data(), x.data());
  for (double& volume : log_volume) volume = 4.0 * decid::log(std::abs(volume));
}

void Reparameterisation::from_density(std::span<const double> x, std::span<double> y, Workspace& work, Isa isa) const {
  std::copy(x.begin(), x.end(), y.begin());
  if (empty()) return;
  widths(x, work, isa);
  for (double& feature : work.features) feature = -feature;
  kernels(isa).add_matrix_times(static_cast<int>(noises_), static_cast<int>(features()), shift_by_coefficient_.data(),
                                work.features.data(), y.data());
  for (std::size_t i = 0; i < noises_ * lanes; ++i) {
    const double square = (0.25 * work.root[i]) * (0.25 * work.root[i]);
    y[i] /= square * square;
  }
}

void Reparameterisation::pull_back(std::span<const double> y, std::span<double> gradient, Workspace& work,
                                   Isa isa) const {
  if (empty()) return;
  const Kernels& run = kernels(isa);
  const int size = static_cast<int>(noises_);
  work.by_features.assign(features() * lanes, 0.0);
  run.add_matrix_times(static_cast<int>(features()), size, shift_by_feature_.data(), gradient.data(),
                       work.by_features.data());
  work.by_root.resize(noises_ * lanes);
  run.stretch_gradient(size, work.root.data(), work.cube.data(), y.data(), gradient.data(), work.by_root.data());
  run.add_matrix_times(static_cast<int>(variables()), size, width_by_variable_.data(), work.by_root.data(),
                       work.by_features.data() + lanes);
  for (std::size_t l = 0; l < lanes; ++l) {
    const auto by = [&](std::size_t feature) { return work.by_features[feature * lanes + l]; };
    std::size_t feature = 1 + variables();
    for (std::size_t a = 0; a < variables(); ++a) {
      double by_z = by(1 + a);
      for (std::size_t b = 0; b < a; ++b) by_z = std::fma(by(feature + b), work.z[b][l], by_z);
      by_z = std::fma(2.0 * by(feature + a), work.z[a][l], by_z);
      for (std::size_t c = a + 1, later = feature + a + 1; c < variables(); later += ++c)
        by_z = std::fma(by(later + a), work.z[c][l], by_z);
      feature += a + 1;
      double& to = gradient[(noises_ + variable_[a]) * lanes + l];
      to = std::fma(by_z, work.slope[a][l], to);
    }
  }
}

// With D the diagonal of q^4 and M the change of w with the coordinates of v at constant u: D H_ww D,
// (H_vw + M^t H_ww) D, and H_vv + M^t H_wv + H_vw M + M^t H_ww M.
void Reparameterisation::change_information(std::span<const double> x, std::span<double> information, Workspace& work,
                                            Isa isa) const {
  if (empty()) return;
  const Kernels& run = kernels(isa);
  const int size = static_cast<int>(noises_);
  AlignedVector<double> y(x.size());
  from_density(x, y, work, isa);
  for (double& feature : work.features) feature = -feature;
  Lanes volume;
  AlignedVector<double> ones(noises_ * lanes, 1.0);  // becomes D
  run.stretch(size, work.root.data(), work.cube.data(), ones.data(), volume.data());
  std::vector<AlignedVector<double>> slopes(variables()), products(variables());
  AlignedVector<double> changes(features() * lanes);
  for (std::size_t a = 0; a < variables(); ++a) {
    std::fill(changes.begin(), changes.end(), 0.0);
    for (std::size_t l = 0; l < lanes; ++l) {
      changes[(1 + a) * lanes + l] = work.slope[a][l];
      std::size_t feature = 1 + variables();
      for (std::size_t b = 0; b < variables(); ++b) {
        for (std::size_t c = 0; c <= b; ++c, ++feature) {
          const double change = (a == b ? work.z[c][l] : 0.0) + (a == c ? work.z[b][l] : 0.0);
          changes[feature * lanes + l] = change * work.slope[a][l];
        }
      }
    }
    slopes[a].assign(noises_ * lanes, 0.0);
    run.add_matrix_times(size, static_cast<int>(features()), shift_by_coefficient_.data(), changes.data(),
                         slopes[a].data());
    for (std::size_t i = 0; i < noises_; ++i)
      for (std::size_t l = 0; l < lanes; ++l)
        slopes[a][i * lanes + l] +=
            width_by_coefficient_[i * variables() + a] * work.slope[a][l] * work.cube[i * lanes + l] * y[i * lanes + l];
    products[a].assign(noises_ * lanes, 0.0);
    run.symmetric_times(size, information.data(), slopes[a].data(), products[a].data());
  }
  const auto row = [&](std::size_t global) { return information.data() + triangle(noises_ + global) * lanes; };
  for (std::size_t a = 0; a < variables(); ++a) {
    for (std::size_t global = 0; global < globals_; ++global) {
      const auto b = static_cast<std::size_t>(std::ranges::find(variable_, global) - variable_.begin());
      if (b < a) continue;  // each pair of variables once
      const std::size_t high = std::max(global, variable_[a]), low = std::min(global, variable_[a]);
      double* to = row(high) + (noises_ + low) * lanes;
      const double *of_a = row(variable_[a]), *of_global = row(global);
      for (std::size_t i = 0; i < noises_ * lanes; ++i) {
        double* here = to + i % lanes;
        *here = std::fma(slopes[a][i], of_global[i], *here);
        if (b == variables()) continue;
        *here = std::fma(slopes[b][i], of_a[i], *here);
        *here = std::fma(slopes[a][i], products[b][i], *here);
      }
    }
  }
  for (std::size_t a = 0; a < variables(); ++a)
    for (std::size_t i = 0; i < noises_ * lanes; ++i) row(variable_[a])[i] += products[a][i];
  for (std::size_t r = 0; r < noises_ + globals_; ++r) {
    double* values = information.data() + triangle(r) * lanes;
    for (std::size_t i = 0; i < std::min(noises_, r + 1) * lanes; ++i)
      values[i] *= ones[i] * (r < noises_ ? ones[r * lanes + i % lanes] : 1.0);
  }
}

}  // namespace decid::posterior
