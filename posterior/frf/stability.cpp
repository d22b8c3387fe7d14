// Stability of the family's closed loop: see stability.hpp.
#include "posterior/frf/stability.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/math/math.hpp"

namespace decid::frf {
namespace {

using Polynomial = std::vector<double>;  // from the constant term upwards

constexpr int max_halvings = 200;

double value(const Polynomial& p, double x) {
  double sum = 0.0;
  for (std::size_t i = p.size(); i-- > 0;) sum = sum * x + p[i];
  return sum;
}

Polynomial product(const Polynomial& a, const Polynomial& b) {
  Polynomial made(a.size() + b.size() - 1, 0.0);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) made[i + j] += a[i] * b[j];
  return made;
}

Polynomial sum(Polynomial a, const Polynomial& b, double factor = 1.0) {
  if (a.size() < b.size()) a.resize(b.size(), 0.0);
  for (std::size_t i = 0; i < b.size(); ++i) a[i] += factor * b[i];
  return a;
}

Polynomial derivative(const Polynomial& p) {
  Polynomial made;
  for (std::size_t i = 1; i < p.size(); ++i) made.push_back(static_cast<double>(i) * p[i]);
  return made;
}

/// Returns the root between two places with values of different signs.
double root_between(const Polynomial& p, double low, double high) {
  const bool rises = value(p, high) > 0.0;
  for (int i = 0; i < max_halvings; ++i) {
    const double middle = 0.5 * (low + high);
    if (!(middle > low && middle < high)) break;
    (value(p, middle) > 0.0) == rises ? high = middle : low = middle;
    if (high - low <= 1e-12 * high) break;
  }
  return 0.5 * (low + high);
}

/// Returns the positive roots at which the polynomial changes its sign, ascending. They lie between its derivative's.
std::vector<double> positive_roots(const Polynomial& p) {
  if (p.size() < 2) return {};
  std::vector<double> places{0.0};
  for (const double turn : positive_roots(derivative(p))) places.push_back(turn);
  double largest = 0.0;  // Cauchy's bound
  for (std::size_t i = 0; i + 1 < p.size(); ++i) largest = std::max(largest, std::abs(p[i] / p.back()));
  places.push_back(std::max(places.back(), 1.0) + 1.0 + largest);
  std::vector<double> roots;
  for (std::size_t i = 0; i + 1 < places.size(); ++i)
    if ((value(p, places[i]) > 0.0) != (value(p, places[i + 1]) > 0.0))
      roots.push_back(root_between(p, places[i], places[i + 1]));
  return roots;
}

/// Returns the number of roots with a positive real part: the changes of sign in the first column of Routh's table.
int right_roots(const Polynomial& p) {
  const std::size_t degree = p.size() - 1, width = degree / 2 + 2;
  Polynomial above(width, 0.0), here(width, 0.0);
  for (std::size_t i = 0; i <= degree; ++i) (i % 2 == 0 ? above : here)[i / 2] = p[degree - i];
  int changes = 0;
  for (std::size_t row = 1; row <= degree; ++row) {
    if (here[0] == 0.0) here[0] = std::numeric_limits<double>::min();
    changes += (here[0] > 0.0) != (above[0] > 0.0) ? 1 : 0;
    Polynomial next(width, 0.0);
    for (std::size_t i = 0; i + 1 < width; ++i) next[i] = above[i + 1] - above[0] / here[0] * here[i + 1];
    above = std::move(here);
    here = std::move(next);
  }
  return changes;
}

/// Returns |p(i w)|^2 as a polynomial of w^2.
Polynomial power(const Polynomial& p) {
  Polynomial even, odd;  // p(i w) = even(w^2) + i w odd(w^2)
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double sign = (i / 2) % 2 == 0 ? 1.0 : -1.0;
    (i % 2 == 0 ? even : odd).push_back(sign * p[i]);
  }
  Polynomial made = product(even, even);
  if (odd.empty()) return made;
  Polynomial shifted = product(odd, odd);
  shifted.insert(shifted.begin(), 0.0);
  return sum(made, shifted);
}

/// Returns the angle of p(i w).
double angle(const Polynomial& p, double w) {
  double real = 0.0, imaginary = 0.0, power_of_w = 1.0;
  for (std::size_t i = 0; i < p.size(); ++i, power_of_w *= w) {
    const double term = p[i] * power_of_w;
    (i % 2 == 0 ? real : imaginary) += (i / 2) % 2 == 0 ? term : -term;
  }
  return decid::atan2(imaginary, real);
}

/// Loops with unit gains. Where 2 kp exceeds the lean, the loop is stable without delay. On the imaginary axis
/// |J s^2 - lean + kd_pass s| = |2 (kp + kd s)| has at most one solution s = i w, w > 0, if kp_pass is at most
/// m g h + 2 kp: the first delay that puts a root there makes the loop permanently unstable. With a larger kp_pass it
/// may have two. At the larger w, which this takes, roots go to the right. At the smaller one they go back, so the loop
/// may become stable again at longer delays; it counts as unstable there. Without damping nothing settles, and rounding
/// would decide. Gains above max_gain_over_mgh lose the digits of the difference in `square`.
bool is_stable_with_unit_gains(const sim::Body& body, const sim::Coefficients& c) {
  using enum sim::Coefficient;
  const double j = body.inertia_kgm2, lean = body.mgh() - c[kp_pass];
  if (2.0 * c[kp] <= lean || (c[kd] <= 0.0 && c[kd_pass] <= 0.0)) return false;
  constexpr double max_gain_over_mgh = 1e6;  // no controller's
  if (std::max({c[kp], c[kd], c[kp_pass], c[kd_pass]}) > max_gain_over_mgh * body.mgh()) return false;
  const double half = j * lean + 0.5 * c[kd_pass] * c[kd_pass] - 2.0 * c[kd] * c[kd];
  const double rest = lean * lean - 4.0 * c[kp] * c[kp], inside = half * half - j * j * rest;
  if (inside < 0.0) return true;
  const double square = (std::sqrt(inside) - half) / (j * j);
  if (square <= 0.0) return true;
  const double w = std::sqrt(square);
  return w * c[delay] < decid::atan2(w * c[kd], c[kp]) + decid::atan2(w * c[kd_pass], j * square + lean);
}

/// Returns the place between a stable and an unstable one at which the stability changes.
template <class IsStableAt>
double border_between(const IsStableAt& is_stable_at, double stable, double unstable) {
  constexpr int halvings = 40;
  for (int i = 0; i < halvings; ++i) {
    const double middle = 0.5 * (stable + unstable);
    (is_stable_at(middle) ? stable : unstable) = middle;
  }
  return stable;
}

/// Returns the first place of instability on the way from a stable place to `end`, or `end`. next: the place after one.
template <class IsStableAt, class Next>
double first_border(const IsStableAt& is_stable_at, double from, double end, const Next& next) {
  for (double here = from; here != end;) {
    const double there = next(here);
    if (!is_stable_at(there)) return border_between(is_stable_at, here, there);
    here = there;
  }
  return end;
}

}  // namespace

int unstable_roots(const std::vector<double>& a, const std::vector<double>& b, double delay_s) {
  int count = right_roots(sum(a, b));
  const Polynomial difference = sum(power(a), power(b), -1.0);
  bool above = value(difference, 0.0) > 0.0;
  for (const double square : positive_roots(difference)) {
    above = !above;  // |A| above |B| behind the crossing: roots go to the right
    const double w = std::sqrt(square);
    // A + exp(-i w delay) B = 0: the angle of B is pi + w delay ahead of A's.
    double turn = angle(b, w) - angle(a, w) + sim::pi;
    turn -= 2.0 * sim::pi * std::floor(turn / (2.0 * sim::pi));
    const double passed = (w * delay_s - turn) / (2.0 * sim::pi);
    if (passed < 0.0) continue;
    const int crossings = static_cast<int>(passed) + 1;
    count += (above ? 2 : -2) * crossings;
  }
  return count;
}

bool is_stable(const sim::Body& body, const sim::Family& family, const sim::Coefficients& c) {
  using enum sim::Coefficient;
  if (family.has_unit_gains()) return is_stable_with_unit_gains(body, c);
  // Times (s + 1 / slow_time) and (s + 1 / torque_time), in units of m g h:
  //   A = J s^2 + kd_pass s + kp_pass - m g h
  //   B = (kp + kd s) (position + gravity + slow / (s + 1 / slow_time) - torque A / (s + 1 / torque_time))
  const double mgh = body.mgh(), reach = c[position] + c[gravity];
  const Polynomial passive{(c[kp_pass] - mgh) / mgh, c[kd_pass] / mgh, body.inertia_kgm2 / mgh};
  const Polynomial servo{c[kp] / mgh, c[kd] / mgh};
  Polynomial a = passive, b{reach}, leaks{1.0};
  if (family.varies(slow, 0.0)) {
    const Polynomial leak{1.0 / family.slow_time_s, 1.0};
    a = product(a, leak);
    b = sum(product(b, leak), {c[slow]});
    leaks = leak;
  }
  if (family.varies(torque, 0.0)) {
    if (c[delay] > 0.0 && c[kd] * c[torque] >= mgh) return false;  // neutral, with infinitely many unstable roots
    const Polynomial leak{1.0 / family.torque_time_s, 1.0};
    a = product(a, leak);
    b = sum(product(b, leak), product(leaks, passive), -c[torque]);
  }
  return unstable_roots(a, product(servo, b), c[delay]) == 0;
}

StabilityMargins stability_margins(const sim::Body& body, const sim::Family& family, const sim::Coefficients& c) {
  using enum sim::Coefficient;
  constexpr double delay_step_s = 0.0005, gain_step = 1.02, min_gain = 0.01;
  StabilityMargins found;
  found.stable = is_stable(body, family, c);
  if (!found.stable) return found;
  const auto stable_later = [&](double delay_s) {
    sim::Coefficients later = c;
    later[delay] += delay_s;
    return is_stable(body, family, later);
  };
  const auto stable_with = [&](double factor) {
    sim::Coefficients other = c;
    other[kp] *= factor;
    other[kd] *= factor;
    return is_stable(body, family, other);
  };
  found.delay_s = first_border(stable_later, 0.0, max_delay_margin_s,
                               [](double delay_s) { return std::min(delay_s + delay_step_s, max_delay_margin_s); });
  found.gain_low =
      first_border(stable_with, 1.0, 0.0, [](double factor) { return factor > min_gain ? factor / gain_step : 0.0; });
  found.gain_high = first_border(stable_with, 1.0, max_gain_margin,
                                 [](double factor) { return std::min(factor * gain_step, max_gain_margin); });
  return found;
}

}  // namespace decid::frf
