// The trials that chains sample together: see target.hpp.
#include "posterior/sampling/target.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "base/math/cholesky.hpp"
#include "base/math/math.hpp"
#include "base/text.hpp"

namespace decid::posterior {
namespace {

std::size_t noises(const Density& density) {
  return static_cast<std::size_t>(density.noise_size());
}
std::size_t parameters(const Density& density) {
  return static_cast<std::size_t>(density.parameters());
}

}  // namespace

Target::Target(const Density& density, const Observation& observation) : trials_{{&density, &observation}} {}

Target::Target(std::vector<TargetTrial> trials) : trials_(std::move(trials)) {
  const auto refuse = [](const std::string& problem, const char* remedy) {
    throw Error(Code::value_invalid, "joint posterior", problem, remedy);
  };
  if (trials_.empty()) refuse("has no trial", "give one or more");
  if (trials_.size() == 1 && trials_.front().common.empty()) return;
  std::vector<const Density*> first;  // with each common unknown
  std::vector<std::size_t> place;
  for (std::size_t t = 0; t < trials_.size(); ++t) {
    const Density& density = *trials_[t].density;
    const std::vector<std::size_t>& common = trials_[t].common;
    if (common.size() != parameters(density))
      refuse(format("trial %zu has %zu common unknowns for %zu parameters", t + 1, common.size(), parameters(density)),
             "give one for each parameter");
    for (std::size_t p = 0; p < common.size(); ++p) {
      if (std::ranges::count(common, common[p]) != 1)
        refuse(format("two parameters of trial %zu are the same", t + 1), "give each its own common unknown");
      if (common[p] >= uses_.size()) {
        uses_.resize(common[p] + 1, 0);
        first.resize(uses_.size(), nullptr);
        place.resize(uses_.size(), 0);
      }
      if (uses_[common[p]]++ == 0) {
        first[common[p]] = &density;
        place[common[p]] = p;
      } else if (first[common[p]]->quantile(place[common[p]]) != density.quantile(p)) {
        refuse("parameter " + density.ranges()[p].name + format(" of trial %zu has another prior or range", t + 1),
               "give trials of one body and controller the same ranges and priors");
      }
    }
  }
  if (std::ranges::count(uses_, 0) != 0) refuse("numbers of common unknowns have a gap", "count them from 0");
}

std::size_t Target::own(std::size_t trial) const {
  return static_cast<std::size_t>(density(trial).size()) - trials_[trial].common.size();
}

std::size_t Target::own_globals(std::size_t trial) const {
  return static_cast<std::size_t>(density(trial).globals()) - trials_[trial].common.size();
}

std::size_t Target::globals() const {
  std::size_t count = commons();
  for (std::size_t t = 0; t < trials(); ++t) count += own_globals(t);
  return count;
}

void Target::to_rows(std::size_t trial, std::span<const double> coordinates, std::span<double> rows) const {
  const std::vector<std::size_t>& common = trials_[trial].common;
  const std::size_t first = noises(density(trial)) * lanes, after = first + common.size() * lanes;
  const auto end = std::copy_n(coordinates.begin(), first, rows.begin());
  std::fill(std::copy(coordinates.begin() + static_cast<std::ptrdiff_t>(after), coordinates.end(), end), rows.end(),
            0.0);
  for (std::size_t p = 0; p < common.size(); ++p)
    std::ranges::copy(coordinates.subspan(first + p * lanes, lanes),
                      rows.subspan((own(trial) + common[p]) * lanes, lanes).begin());
}

void Target::from_rows(std::size_t trial, std::span<const double> rows, std::span<double> coordinates) const {
  const std::vector<std::size_t>& common = trials_[trial].common;
  const std::size_t first = noises(density(trial)) * lanes, after = first + common.size() * lanes;
  std::ranges::copy(rows.first(first), coordinates.begin());
  std::ranges::copy(rows.subspan(first, coordinates.size() - after), coordinates.subspan(after).begin());
  for (std::size_t p = 0; p < common.size(); ++p)
    std::ranges::copy(rows.subspan((own(trial) + common[p]) * lanes, lanes),
                      coordinates.subspan(first + p * lanes, lanes).begin());
}

void Target::count_once(std::size_t trial, std::span<const double> x, std::span<double> gradient,
                        Lanes& potential) const {
  const std::vector<std::size_t>& common = trials_[trial].common;
  for (std::size_t p = 0; p < common.size(); ++p) {
    const auto has_it = [&](const TargetTrial& earlier) {
      return std::ranges::find(earlier.common, common[p]) != earlier.common.end();
    };
    if (std::none_of(trials_.begin(), trials_.begin() + static_cast<std::ptrdiff_t>(trial), has_it)) continue;
    const std::size_t at = (noises(density(trial)) + p) * lanes;
    for (std::size_t l = 0; l < lanes; ++l) {
      potential[l] -= 0.5 * x[at + l] * x[at + l];
      gradient[at + l] -= x[at + l];
    }
  }
}

void Target::parameters_last(std::size_t trial, std::span<double> matrix, std::size_t width) const {
  if (!joint()) return;
  const Density& d = density(trial);
  const std::size_t size = static_cast<std::size_t>(d.size()), first = noises(d), count = parameters(d);
  const auto before = [&](std::size_t row) {  // its row in the Density's order
    if (row < first) return row;
    return row < size - count ? row + count : first + row - (size - count);
  };
  const std::vector<double> old(matrix.begin() + static_cast<std::ptrdiff_t>(triangle(first) * width), matrix.end());
  const auto element = [&](std::size_t i, std::size_t j) {
    const auto [low, high] = std::minmax(i, j);
    return old.begin() + static_cast<std::ptrdiff_t>((triangle(high) + low - triangle(first)) * width);
  };
  for (std::size_t i = first; i < size; ++i)
    for (std::size_t j = 0; j <= i; ++j)
      std::copy_n(element(before(i), before(j)), width,
                  matrix.begin() + static_cast<std::ptrdiff_t>((triangle(i) + j) * width));
}

template <class Element>
void Target::add_corner(std::size_t trial, const Element& element, std::span<double> corner) const {
  const std::vector<std::size_t>& common = trials_[trial].common;
  for (std::size_t p = 0; p < common.size(); ++p) {
    for (std::size_t q = 0; q <= p; ++q) {
      const auto [low, high] = std::minmax(common[p], common[q]);
      double& sum = corner[triangle(high) + low];
      for (std::size_t k = 0; k <= q; ++k)
        sum = std::fma(element(own(trial) + p, own(trial) + k), element(own(trial) + q, own(trial) + k), sum);
    }
  }
}

bool Target::metric(std::span<const std::vector<double>> informations, std::size_t held,
                    std::vector<std::vector<double>>& inverse_factors) const {
  std::vector<std::vector<double>> factors(informations.begin(), informations.end());
  std::vector<double> corner(triangle(commons()), 0.0);
  for (std::size_t i = 0; i < commons(); ++i) corner[triangle(i) + i] = 1.0 - uses_[i];  // of priors
  for (std::size_t t = 0; t < trials(); ++t) {
    std::vector<double>& factor = factors[t];
    const std::size_t size = own(t) + trials_[t].common.size();
    for (std::size_t row = own(t) - held; row < own(t); ++row) {
      std::fill_n(factor.begin() + static_cast<std::ptrdiff_t>(triangle(row)), row, 0.0);
      for (std::size_t later = row; later < size; ++later) factor[triangle(later) + row] = later == row ? 1.0 : 0.0;
    }
    if (!decid::factorize(size, factor)) return false;
    add_corner(
        t, [&](std::size_t i, std::size_t j) { return factor[triangle(i) + j]; }, corner);
  }
  if (!decid::factorize(commons(), corner)) return false;
  for (std::size_t t = 0; t < trials(); ++t) {
    const std::size_t begin = triangle(own(t));
    const std::vector<double> parameter_rows(factors[t].begin() + static_cast<std::ptrdiff_t>(begin), factors[t].end());
    factors[t].resize(begin);
    factors[t].resize(triangle(rows(t)), 0.0);
    for (std::size_t p = 0; p < trials_[t].common.size(); ++p)
      std::copy_n(parameter_rows.begin() + static_cast<std::ptrdiff_t>(triangle(own(t) + p) - begin), own(t),
                  factors[t].begin() + static_cast<std::ptrdiff_t>(triangle(own(t) + trials_[t].common[p])));
    for (std::size_t i = 0; i < commons(); ++i)
      std::copy_n(corner.begin() + static_cast<std::ptrdiff_t>(triangle(i)), i + 1,
                  factors[t].begin() + static_cast<std::ptrdiff_t>(triangle(own(t) + i) + own(t)));
    invert_lower(rows(t), factors[t]);
  }
  inverse_factors = std::move(factors);
  return true;
}

Target::Lanes Target::half_log_determinant(std::span<const std::vector<double>> factors) const {
  Lanes sums{};
  for (std::size_t l = 0; l < lanes; ++l) {
    std::vector<double> corner(triangle(commons()), 0.0);
    for (std::size_t i = 0; i < commons(); ++i) corner[triangle(i) + i] = 1.0 - uses_[i];
    for (std::size_t t = 0; t < trials(); ++t) {
      const auto element = [&](std::size_t i, std::size_t j) { return factors[t][(triangle(i) + j) * lanes + l]; };
      for (std::size_t i = 0; i < own(t); ++i) sums[l] += decid::log(element(i, i));
      add_corner(t, element, corner);
    }
    if (!joint()) continue;
    if (!decid::factorize(commons(), corner)) {
      sums[l] = std::numeric_limits<double>::quiet_NaN();
      continue;
    }
    for (std::size_t i = 0; i < commons(); ++i) sums[l] += decid::log(corner[triangle(i) + i]);
  }
  return sums;
}

void Target::append_globals(std::span<const AlignedVector<double>> x, std::vector<std::vector<double>>& points) const {
  for (std::size_t l = 0; l < lanes; ++l) {
    std::vector<double> own_ones, common_ones(commons());
    for (std::size_t t = 0; t < trials(); ++t) {
      const std::vector<std::size_t>& common = trials_[t].common;
      for (std::size_t g = 0; g < static_cast<std::size_t>(density(t).globals()); ++g) {
        const double value = x[t][(noises(density(t)) + g) * lanes + l];
        if (g < common.size())
          common_ones[common[g]] = value;
        else
          own_ones.push_back(value);
      }
    }
    own_ones.insert(own_ones.end(), common_ones.begin(), common_ones.end());
    points.push_back(std::move(own_ones));
  }
}

}  // namespace decid::posterior
