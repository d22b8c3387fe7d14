// Looks for a movement that is not a standing body's: see movements.hpp.
#include "recording/quality/detail/movements.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

#include "base/math/math.hpp"
#include "base/math/statistics.hpp"
#include "recording/quality/detail/whitened.hpp"

namespace decid::recording {

namespace {

constexpr std::array lengths_s{1.0, 1.5, 2.0, 3.0, 4.0};
constexpr double step_time_s = 0.2, step_reach_s = 1.5;
constexpr double min_energy = 0.2;  ///< of the shape's

struct Shape {
  std::size_t size;          ///< of the movement
  std::vector<double> form;  ///< its innovations
  double energy = 0.0;
  bool is_step = false;
};

Shape shape_of(std::vector<double> values, bool is_step, std::span<const double> a) {
  Shape shape{values.size(), {}, 0.0, is_step};
  if (!is_step) values.resize(values.size() + a.size(), 0.0);
  shape.form = whitened(values, a);
  for (const double value : shape.form) shape.energy += value * value;
  return shape;
}

std::vector<Shape> shapes_of(std::span<const double> a, double step_s) {
  std::vector<Shape> shapes;
  for (const double length_s : lengths_s) {
    std::vector<double> values;  // a raised cosine
    const auto steps = static_cast<int>(std::round(length_s / step_s));
    for (int k = 1; k < steps; ++k) {
      const double sine = sincos_of_turn(k, 2LL * steps).sin;
      values.push_back(sine * sine);
    }
    shapes.push_back(shape_of(std::move(values), false, a));
  }
  std::vector<double> values;
  const auto reach = static_cast<int>(std::round(step_reach_s / step_s));
  for (int k = -reach; k <= reach; ++k) values.push_back(1.0 / (1.0 + decid::exp(-k * step_s / step_time_s)));
  shapes.push_back(shape_of(std::move(values), true, a));
  return shapes;
}

/// Innovations, and which of them depend on measured values only.
class Innovations {
 public:
  Innovations(std::span<const double> noise, std::span<const double> a, const std::vector<bool>& is_measured)
      : first_(std::ssize(a)), values_(whitened(noise, a)) {
    if (is_measured.empty()) return;
    is_known_.assign(values_.size(), true);
    for (std::size_t k = 0; k < is_measured.size(); ++k)
      for (std::size_t i = k; !is_measured[k] && i < std::min(k + a.size() + 1, is_known_.size()); ++i)
        is_known_[i] = false;
    for (std::size_t k = 0; k < values_.size(); ++k)
      if (!is_known_[k]) values_[k] = 0.0;
  }

  struct Match {
    double correlation = 0.0, size = 0.0;  ///< 0: too little of the shape is measured
  };
  /// Compares with a shape that begins at block `place`, which may lie before the first one.
  Match compare(const Shape& shape, std::ptrdiff_t place) const {
    const std::ptrdiff_t end = std::min(place + std::ssize(shape.form), std::ssize(values_)),
                         begin = std::max(place, first_);
    if (begin >= end) return {};
    const auto form = shape.form.begin() + (begin - place), form_end = shape.form.begin() + (end - place);
    const double sum = std::inner_product(form, form_end, values_.begin() + begin, 0.0);
    double energy = shape.energy;
    if (!is_known_.empty() || form_end - form < std::ssize(shape.form)) {
      energy = 0.0;
      for (std::ptrdiff_t k = begin; k < end; ++k)
        if (is_known_.empty() || is_known_[static_cast<std::size_t>(k)]) energy += form[k - begin] * form[k - begin];
    }
    if (!(energy > min_energy * shape.energy)) return {};
    return {sum / std::sqrt(energy), sum / energy};
  }

 private:
  std::ptrdiff_t first_;
  std::vector<double> values_;
  std::vector<bool> is_known_;  // empty: all
};

}  // namespace

Movement find_movement(std::span<const double> noise, std::span<const double> a, const std::vector<bool>& is_measured,
                       double step_s) {
  const Innovations innovations(noise, a, is_measured);
  // Forwards, the first values have no innovations. Backwards the same autoregression holds, and they are the last
  // ones.
  const Innovations backwards(std::vector<double>(noise.rbegin(), noise.rend()), a,
                              std::vector<bool>(is_measured.rbegin(), is_measured.rend()));
  const auto blocks = std::ssize(noise), order = std::ssize(a);
  Movement found;
  std::vector<double> sizes;
  for (const Shape& shape : shapes_of(a, step_s)) {
    const auto size = static_cast<std::ptrdiff_t>(shape.size);
    Innovations::Match best;
    std::ptrdiff_t best_at = 0;
    sizes.clear();
    for (std::ptrdiff_t place = order - size / 2; place < blocks - size / 2; ++place) {
      const Innovations::Match match = innovations.compare(shape, place);
      if (match.correlation == 0.0) continue;
      sizes.push_back(std::abs(match.correlation));
      if (sizes.back() > std::abs(best.correlation)) {
        best = match;
        best_at = place;
      }
    }
    for (std::ptrdiff_t place = 0; !shape.is_step && place <= size / 2 + order; ++place) {  // of the last block
      const Innovations::Match match = backwards.compare(shape, blocks - 1 - size / 2 - place);
      if (std::abs(match.correlation) <= std::abs(best.correlation)) continue;
      best = match;
      best_at = place + size / 2 + 1 - size;
    }
    if (sizes.empty()) continue;
    const double typical = stddev_by_median(sizes);
    if (!(std::abs(best.correlation) > found.deviations * typical)) continue;
    found = {std::abs(best.correlation) / typical, best.size,
             static_cast<double>(std::max<std::ptrdiff_t>(0, best_at)) * step_s,
             static_cast<double>(std::min(blocks, best_at + size)) * step_s, shape.is_step};
  }
  return found;
}

}  // namespace decid::recording
