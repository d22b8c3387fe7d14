// The fit of a Reparameterisation to points that chains visit: see reparameterisation.hpp.
#include <algorithm>
#include <cmath>

#include "base/math/cholesky.hpp"
#include "base/math/math.hpp"
#include "posterior/kernels/kernels.hpp"
#include "posterior/sampling/reparameterisation.hpp"

namespace decid::posterior {
namespace {

// Chosen on trials of a seed that is used for no published figure.
constexpr double value_weight = 0.1;  // of a point's noise, in addition to its slopes
constexpr double min_scale = 1e-3;    // of a variable, as a fraction of its range
constexpr double typical_density = 0.3;
constexpr double shrinkage = 5e-3;  // of squares, per point with slopes; of widths, per point
constexpr std::size_t min_points = 16;

}  // namespace

/// Rows of features with a target for each noise coefficient; solves all coefficients at once.
struct ReparameterisationFit::LeastSquares {
  LeastSquares(std::size_t feature_count, std::size_t target_count)
      : features(feature_count), groups((target_count + lanes - 1) / lanes), targets(target_count) {}

  void add(std::span<const double> row, std::span<const double> target, double root_weight, double factor = 1.0) {
    for (const double value : row) matrix.push_back(value * root_weight);
    for (std::size_t k = 0; k < groups * lanes; ++k)
      right.push_back(k < targets ? target[k] * factor * root_weight : 0.0);
  }

  /// Solves for one row per feature; returns nothing without a solution. damping: added to the sum of squares of each
  /// feature.
  std::vector<double> solve(std::span<const double> damping, Isa isa) const {
    const std::size_t rows = matrix.size() / features;
    const Kernels& run = kernels(isa);
    std::vector<double> normal(triangle(features), 0.0), transposed(matrix.size());
    for (std::size_t i = 0; i < features; ++i) {
      for (std::size_t n = 0; n < rows; ++n) transposed[i * rows + n] = matrix[n * features + i];
      for (std::size_t j = 0; j <= i; ++j)
        for (std::size_t n = 0; n < rows; ++n)
          normal[triangle(i) + j] =
              std::fma(transposed[i * rows + n], transposed[j * rows + n], normal[triangle(i) + j]);
      normal[triangle(i) + i] += damping[i];
    }
    AlignedVector<double> work(inverse_work(features));
    if (!run.inverse_factor(static_cast<int>(features), normal.data(), work.data())) return {};
    std::vector<double> solution(features * targets);
    AlignedVector<double> in(rows * lanes), product(features * lanes), half(features * lanes), out(features * lanes);
    for (std::size_t group = 0; group < groups; ++group) {
      for (std::size_t n = 0; n < rows; ++n)
        std::copy_n(right.begin() + static_cast<std::ptrdiff_t>((n * groups + group) * lanes), lanes,
                    in.begin() + static_cast<std::ptrdiff_t>(n * lanes));
      std::fill(product.begin(), product.end(), 0.0);
      const auto size = static_cast<int>(features);
      run.add_matrix_times(size, static_cast<int>(rows), transposed.data(), in.data(), product.data());
      run.lower_times(size, normal.data(), product.data(), half.data());
      run.upper_times(size, normal.data(), half.data(), out.data());
      for (std::size_t f = 0; f < features; ++f)
        for (std::size_t l = 0; l < lanes && group * lanes + l < targets; ++l)
          solution[f * targets + group * lanes + l] = out[f * lanes + l];
    }
    return solution;
  }

  std::size_t features, groups, targets;
  std::vector<double> matrix, right;
};

ReparameterisationFit::ReparameterisationFit(const Density& density, bool parameters_last)
    : density_(density), parameters_last_(parameters_last) {
  for (std::size_t global = 0; global < static_cast<std::size_t>(density.globals()); ++global)
    if (density.infers(density.quantity(global)) && !density.is_held(global)) variable_.push_back(global);
}

std::size_t ReparameterisationFit::row(std::size_t global) const {
  const auto noises = static_cast<std::size_t>(density_.noise_size()),
             parameters = static_cast<std::size_t>(density_.parameters()),
             others = static_cast<std::size_t>(density_.globals()) - parameters;
  if (!parameters_last_) return noises + global;
  return noises + (global < parameters ? others + global : global - parameters);
}

void ReparameterisationFit::add(std::span<const double> x) {
  const auto noises = static_cast<std::size_t>(density_.noise_size());
  for (std::size_t l = 0; l < lanes; ++l) {
    Point& point = points_.emplace_back();
    for (const std::size_t global : variable_) point.variables.push_back(x[(noises + global) * lanes + l]);
    for (std::size_t i = 0; i < noises; ++i) point.noise.push_back(x[i * lanes + l]);
  }
}

// Slopes -L_vw L_ww^-1: rows of the factor, solved backwards.
void ReparameterisationFit::add(std::span<const double> x, std::span<double> information) {
  add(x);
  const Kernels& run = kernels(density_.isa());
  const auto noises = static_cast<std::size_t>(density_.noise_size());
  run.factorize(density_.size(), information.data());
  AlignedVector<double> slope(noises * lanes);
  for (const std::size_t global : variable_) {
    const double* values = information.data() + triangle(row(global)) * lanes;
    std::transform(values, values + noises * lanes, slope.begin(), [](double value) { return -value; });
    run.solve_transposed(static_cast<int>(noises), information.data(), slope.data());
    for (std::size_t l = 0; l < lanes; ++l) {
      std::vector<double>& slopes = points_[points_.size() - lanes + l].slopes;
      for (std::size_t i = 0; i < noises; ++i) slopes.push_back(slope[i * lanes + l]);
    }
  }
  for (std::size_t l = 0; l < lanes; ++l) {
    Point& point = points_[points_.size() - lanes + l];
    for (std::size_t i = 0; i < noises; ++i)
      point.log_widths.push_back(-decid::log(information[(triangle(i) + i) * lanes + l]));
    if (std::ranges::all_of(point.slopes, [](double value) { return std::isfinite(value); })) continue;
    point.slopes.clear();
    point.log_widths.clear();
  }
}

void ReparameterisationFit::next_window() {
  before_ = std::move(points_);
  points_.clear();
}

std::vector<const ReparameterisationFit::Point*> ReparameterisationFit::points() const {
  std::vector<const Point*> all;
  for (const Point& point : before_) all.push_back(&point);
  for (const Point& point : points_) all.push_back(&point);
  return all;
}

void ReparameterisationFit::scale(Reparameterisation& fit) const {
  const std::vector<const Point*> all = points();
  const auto count = static_cast<double>(all.size());
  for (std::size_t a = 0; a < variable_.size(); ++a) {
    double sum = 0.0, squares = 0.0;
    for (const Point* point : all) sum += normal_distribution(point->variables[a]);
    for (const Point* point : all) {
      const double off = normal_distribution(point->variables[a]) - sum / count;
      squares = std::fma(off, off, squares);
    }
    fit.middle_.push_back(sum / count);
    fit.scale_.push_back(std::max(min_scale, std::sqrt(squares / count)));
  }
}

ReparameterisationFit::LeastSquares ReparameterisationFit::shifts(const Reparameterisation& fit) const {
  const std::size_t noises = fit.noises_, count = variable_.size();
  LeastSquares squares(fit.features(), noises);
  std::vector<double> z(count), row(fit.features());
  for (const Point* point : points()) {
    for (std::size_t a = 0; a < count; ++a)
      z[a] = (normal_distribution(point->variables[a]) - fit.middle_[a]) / fit.scale_[a];
    row[0] = 1.0;
    std::copy(z.begin(), z.end(), row.begin() + 1);
    std::size_t feature = 1 + count;
    for (std::size_t a = 0; a < count; ++a)
      for (std::size_t b = 0; b <= a; ++b) row[feature++] = z[a] * z[b];
    squares.add(row, point->noise, std::sqrt(value_weight));
    if (point->slopes.empty()) continue;
    for (std::size_t a = 0; a < count; ++a) {
      // The derivative by the coordinate, times a width that makes it about the derivative by z.
      const double width = fit.scale_[a] / typical_density;
      const double steepness = normal_density(point->variables[a]) / typical_density;
      std::fill(row.begin(), row.end(), 0.0);
      row[1 + a] = steepness;
      feature = 1 + count;
      for (std::size_t b = 0; b < count; ++b)
        for (std::size_t c = 0; c <= b; ++c, ++feature)
          row[feature] = steepness * ((a == b ? z[c] : 0.0) + (a == c ? z[b] : 0.0));
      squares.add(row, std::span(point->slopes).subspan(a * noises, noises), 1.0, width);
    }
  }
  return squares;
}

ReparameterisationFit::LeastSquares ReparameterisationFit::log_widths(const Reparameterisation& fit) const {
  const std::size_t count = variable_.size();
  LeastSquares squares(1 + count, fit.noises_);
  std::vector<double> row(1 + count, 1.0);
  for (const Point* point : points()) {
    if (point->log_widths.empty()) continue;
    for (std::size_t a = 0; a < count; ++a)
      row[1 + a] = (normal_distribution(point->variables[a]) - fit.middle_[a]) / fit.scale_[a];
    squares.add(row, point->log_widths, 1.0);
  }
  return squares;
}

Reparameterisation ReparameterisationFit::fit() const {
  const auto with_slopes = static_cast<std::size_t>(
      std::ranges::count_if(points(), [](const Point* point) { return !point->slopes.empty(); }));
  if (with_slopes < min_points) return {};
  Reparameterisation fit;
  const auto noises = static_cast<std::size_t>(density_.noise_size());
  const std::size_t count = variable_.size();
  fit.noises_ = noises;
  fit.globals_ = static_cast<std::size_t>(density_.globals());
  fit.variable_ = variable_;
  scale(fit);
  std::vector<double> damping(fit.features(), shrinkage * static_cast<double>(with_slopes));
  std::fill_n(damping.begin(), 1 + count, 1e-9);
  std::vector<double> shift = shifts(fit).solve(damping, density_.isa());
  const std::vector<double> width_damping(1 + count, shrinkage * static_cast<double>(with_slopes));
  std::vector<double> width = log_widths(fit).solve(width_damping, density_.isa());
  if (shift.empty() || width.empty()) return {};
  width.erase(width.begin(),
              width.begin() + static_cast<std::ptrdiff_t>(noises));  // the constant belongs to the metric
  const auto transposed = [noises](const std::vector<double>& rows) {
    std::vector<double> columns(rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) columns[i % noises * (rows.size() / noises) + i / noises] = rows[i];
    return columns;
  };
  fit.shift_by_coefficient_ = transposed(shift);
  fit.width_by_coefficient_ = transposed(width);
  fit.shift_by_feature_ = std::move(shift);
  fit.width_by_variable_ = std::move(width);
  return fit;
}

}  // namespace decid::posterior
