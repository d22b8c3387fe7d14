// Charts: there and back, gradients, information, and fits of functions that are known.
#include "posterior/sampling/reparameterisation.hpp"

#include <cmath>

#include "base/math/cholesky.hpp"
#include "base/math/math.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"
#include "tests/posterior/trial.hpp"

using namespace decid;
using namespace decid::posterior;
using namespace decid::test;

namespace {

using Values = AlignedVector<double>;

double& at(Values& values, std::size_t i, std::size_t l) {
  return values[i * lanes + l];
}

/// A chart that is fitted to points whose noise, slopes and widths are those of known functions.
struct Fitted {
  sim::Protocol protocol = sines_protocol();
  Density density;
  Observation observation = density.observe(recorded(protocol, some_parameters(), 0.02, 0));
  std::size_t noises = static_cast<std::size_t>(density.noise_size()), size = static_cast<std::size_t>(density.size());
  Random random{11, sim::streams::base_parameters, 0};
  std::size_t globals = static_cast<std::size_t>(density.globals());
  std::uint64_t drawn = 0;
  Reparameterisation chart;
  Reparameterisation::Workspace work;

  explicit Fitted(Priors priors = {}) : density(protocol, priors) {
    ReparameterisationFit fit(density);
    for (int window = 0; window < 2; ++window) {
      fit.next_window();
      for (int i = 0; i < 6; ++i) {
        const Values x = points();
        std::vector<double> information = information_at(x);
        fit.add(x, information);
      }
    }
    chart = fit.fit();
  }

  /// Globals around 0.3, noise as it is most probable there.
  Values points() {
    Values x(size * lanes);
    for (std::size_t l = 0; l < lanes; ++l) {
      for (std::size_t q = 0; q < globals; ++q) at(x, noises + q, l) = 0.3 + 0.4 * random.normal(drawn++);
      for (std::size_t i = 0; i < noises; ++i) at(x, i, l) = shift(x, i, l);
    }
    return x;
  }
  double fraction(const Values& x, std::size_t q, std::size_t l) const {
    return normal_distribution(x[(noises + q) * lanes + l]);
  }
  /// Quadratic in Kp and theta.
  double shift(const Values& x, std::size_t i, std::size_t l) const {
    const double a = fraction(x, 0, l), b = fraction(x, 5, l), c = 0.01 * static_cast<double>(i);
    return c + 2.0 * a - b + 3.0 * c * a * b - a * a;
  }
  /// By the coordinates of Kp and theta.
  std::array<double, 2> slopes(const Values& x, std::size_t i, std::size_t l) const {
    const double a = fraction(x, 0, l), b = fraction(x, 5, l), c = 0.01 * static_cast<double>(i);
    return {(2.0 + 3.0 * c * b - 2.0 * a) * normal_density(x[noises * lanes + l]),
            (-1.0 + 3.0 * c * a) * normal_density(x[(noises + 5) * lanes + l])};
  }
  /// Linear in Kd.
  double log_width(const Values& x, std::size_t i, std::size_t l) const {
    return -1.0 + 0.002 * static_cast<double>(i) * (fraction(x, 1, l) - 0.6);
  }
  /// H_ww = exp(-2 log width), H_vw = -slope H_ww.
  std::vector<double> information_at(const Values& x) const {
    std::vector<double> matrices(triangle(size) * lanes, 0.0);
    for (std::size_t l = 0; l < lanes; ++l) {
      const auto entry = [&](std::size_t row, std::size_t column) -> double& {
        return matrices[(triangle(row) + column) * lanes + l];
      };
      for (std::size_t q = 0; q < globals; ++q) entry(noises + q, noises + q) = 1e5;
      for (std::size_t i = 0; i < noises; ++i) {
        const double precision = decid::exp(-2.0 * log_width(x, i, l));
        entry(i, i) = precision;
        entry(noises, i) = -slopes(x, i, l)[0] * precision;
        entry(noises + 5, i) = -slopes(x, i, l)[1] * precision;
      }
    }
    return matrices;
  }
};

}  // namespace

TEST_CASE("Reparameterisation: without a fit it changes nothing") {
  Fitted f;
  const Values x = f.points();
  Values y(x.size()), back(x.size());
  const Reparameterisation none;
  CHECK(none.empty());
  none.from_density(x, y, f.work, f.density.isa());
  CHECK(y == x);
  Reparameterisation::Lanes log_volume;
  none.to_density(y, back, log_volume, f.work, f.density.isa());
  CHECK(back == x);
  CHECK(log_volume == Reparameterisation::Lanes{});
  CHECK(ReparameterisationFit(f.density).fit().empty());
}

TEST_CASE("Reparameterisation: the fit finds shifts and widths that it can express; there and back is the identity") {
  Fitted f;
  REQUIRE_FALSE(f.chart.empty());
  Values x = f.points(), y(x.size()), back(x.size());
  f.chart.from_density(x, y, f.work, f.density.isa());
  // The residual of noise around the shift: the fit shrinks squares by 5 parts in 1000.
  double squares = 0.0, before = 0.0;
  for (std::size_t i = 0; i < f.noises * lanes; ++i) squares += y[i] * y[i], before += x[i] * x[i];
  CHECK(squares < 1e-3 * before);
  Reparameterisation::Lanes log_volume;
  f.chart.to_density(y, back, log_volume, f.work, f.density.isa());
  for (std::size_t i = 0; i < x.size(); ++i) REQUIRE(within(back[i], x[i], 1e-13 * (1.0 + std::abs(x[i]))));
  // The volume between two values of Kd is that of the widths; the fit of 4 (q - 1) is to a logarithm.
  Values other = x;
  for (std::size_t l = 0; l < lanes; ++l) at(other, f.noises + 1, l) += 0.1;
  Reparameterisation::Lanes other_volume;
  f.chart.to_density(other, back, other_volume, f.work, f.density.isa());
  for (std::size_t l = 0; l < lanes; ++l) {
    double expected = 0.0;
    for (std::size_t i = 0; i < f.noises; ++i) expected += f.log_width(other, i, l) - f.log_width(x, i, l);
    CHECK(near(other_volume[l] - log_volume[l], expected, 0.05));
  }
}

// Central differences of a quadratic form: their error is that of rounding, 1e-16 / 1e-5 of the form, and of the third
// derivative of the fractions, 1e-10.
TEST_CASE("Reparameterisation: the gradient is that of finite differences") {
  Fitted f({.start_s = 0.05, .gain = 0.0});
  const Values x = f.points();
  Values y(x.size());
  f.chart.from_density(x, y, f.work, f.density.isa());
  for (std::size_t i = 0; i < f.noises * lanes; ++i) y[i] += 0.3 * f.random.normal(f.drawn++);
  const auto potential = [&](const Values& point, Values* gradient) {
    Values density_x(point.size());
    Reparameterisation::Lanes log_volume, value{};
    f.chart.to_density(point, density_x, log_volume, f.work, f.density.isa());
    if (gradient) *gradient = density_x;
    for (std::size_t i = 0; i < density_x.size(); ++i) {
      const double factor = 1.0 + 0.01 * static_cast<double>(i / lanes);
      value[i % lanes] += 0.5 * factor * density_x[i] * density_x[i];
      if (gradient) (*gradient)[i] *= factor;
    }
    if (gradient) f.chart.pull_back(point, *gradient, f.work, f.density.isa());
    for (std::size_t l = 0; l < lanes; ++l) value[l] -= log_volume[l];
    return value;
  };
  Values gradient;
  const Reparameterisation::Lanes here = potential(y, &gradient);
  const double step = 1e-5;
  for (std::size_t i = 0; i < f.size; i += i < f.noises ? 9 : 1) {
    Values high = y, low = y;
    for (std::size_t l = 0; l < lanes; ++l) at(high, i, l) += step, at(low, i, l) -= step;
    const Reparameterisation::Lanes above = potential(high, nullptr), below = potential(low, nullptr);
    for (std::size_t l = 0; l < lanes; ++l)
      REQUIRE(within(at(gradient, i, l), (above[l] - below[l]) / (2.0 * step),
                     1e-10 * std::abs(here[l]) + 1e-8 * std::abs(at(gradient, i, l)) + 1e-8));
  }
}

// J^t J of the change of all coordinates, by differences; J of what is seen is that of x itself.
TEST_CASE("Reparameterisation: information changes as the coordinates do") {
  Fitted f;
  Values x = f.points();
  for (std::size_t i = 0; i < f.noises * lanes; ++i) x[i] += 0.2 * f.random.normal(f.drawn++);
  Values y(x.size());
  f.chart.from_density(x, y, f.work, f.density.isa());
  std::vector<double> information = f.information_at(x);
  const std::vector<double> before = information;
  f.chart.change_information(x, information, f.work, f.density.isa());
  const double step = 1e-5;
  const auto change = [&](std::size_t i) {
    Values high = y, low = y, above(x.size()), below(x.size());
    for (std::size_t l = 0; l < lanes; ++l) at(high, i, l) += step, at(low, i, l) -= step;
    Reparameterisation::Lanes log_volume;
    f.chart.to_density(high, above, log_volume, f.work, f.density.isa());
    f.chart.to_density(low, below, log_volume, f.work, f.density.isa());
    for (std::size_t n = 0; n < above.size(); ++n) above[n] = (above[n] - below[n]) / (2.0 * step);
    return above;
  };
  const std::size_t l = 3;
  const auto old_entry = [&](std::size_t a, std::size_t b) {
    return before[(triangle(std::max(a, b)) + std::min(a, b)) * lanes + l];
  };
  std::vector<std::size_t> some{0, 3, 20};
  for (std::size_t q = 0; q < f.globals; ++q) some.push_back(f.noises + q);
  for (const std::size_t a : some) {
    const Values of_a = change(a);
    std::vector<double> product(f.size, 0.0);
    for (std::size_t r = 0; r < f.size; ++r)
      for (std::size_t c = 0; c < f.size; ++c) product[r] += old_entry(r, c) * of_a[c * lanes + l];
    for (const std::size_t b : some) {
      if (b > a) continue;
      const Values of_b = change(b);
      double expected = 0.0, scale = 0.0;
      for (std::size_t r = 0; r < f.size; ++r) {
        expected += of_b[r * lanes + l] * product[r];
        scale += std::abs(of_b[r * lanes + l] * product[r]);
      }
      CHECK(within(information[(triangle(a) + b) * lanes + l], expected, 1e-6 * scale + 1e-9));
    }
  }
}

TEST_CASE("Reparameterisation: the same bits for every instruction set") {
  std::vector<double> first;
  for (const Isa isa : available_isas()) {
    Fitted f;
    const Values x = f.points();
    Values y(x.size()), back(x.size());
    Reparameterisation::Lanes log_volume;
    f.chart.from_density(x, y, f.work, isa);
    f.chart.to_density(y, back, log_volume, f.work, isa);
    f.chart.pull_back(y, back, f.work, isa);
    std::vector<double> information = f.information_at(x);
    f.chart.change_information(x, information, f.work, isa);
    std::vector<double> all(y.begin(), y.end());
    all.insert(all.end(), back.begin(), back.end());
    all.insert(all.end(), log_volume.begin(), log_volume.end());
    all.insert(all.end(), information.begin(), information.end());
    if (first.empty()) first = all;
    CHECK(all == first);
  }
}

TEST_CASE("Reparameterisation: points whose information is no information are left out of the fit") {
  Fitted f;
  ReparameterisationFit fit(f.density);
  for (int i = 0; i < 4; ++i) {
    const Values x = f.points();
    std::vector<double> information = f.information_at(x);
    for (std::size_t l = 2; l < lanes; ++l) information[l] = -1.0;
    fit.add(x, information);
  }
  CHECK(fit.fit().empty());  // 8 points of 32 are left
}
