// Checks a sway: see response_check.hpp. Running sums of the tilt's products reduce each place and size of a slip to
// one small system of equations.
#include "recording/quality/detail/response_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/math/statistics.hpp"
#include "recording/quality/detail/block_means.hpp"
#include "recording/quality/detail/least_squares.hpp"
#include "recording/quality/detail/whitened.hpp"

namespace decid::recording {

namespace {

constexpr double coarse_hz = 10.0, min_trial_s = 40.0;
constexpr std::size_t taps = tilt_lags, order = own_lags;
constexpr std::size_t unknowns = taps + 1;  ///< with c
constexpr std::size_t max_slip = 30, slip_step = 2, margin = 100, place_step = 50;
constexpr std::size_t rest = max_slip + taps + order;  ///< blocks before the trial: more than prediction.hpp needs
constexpr std::size_t max_searched_dead = 17;          ///< of the response, in a recording that starts early
constexpr int rounds = 3;
constexpr double chance_gain = 2.0, chance_gain_more = 5.0, inexact_part = 0.02, max_inexact_gain = 250.0;
constexpr double dead_gain = 60.0;
/// Passive stiffness and damping show in the second block. Without them the active torque shows after its delay.
constexpr std::size_t passive_dead = 1, active_dead = 3, max_passive_dead = 3, max_active_dead = 5;
/// If a tilt's values determine its later ones, as those of few sines do, a later response is nearly an earlier one: of
/// 60 sound simulated recordings for each of three such tilts, 0 to 6 seem to begin 0.5 s or more early.
constexpr std::size_t more_dead = 2;
constexpr double ridge = 1e-3;            ///< of the response to such a tilt
constexpr double determined_part = 1e-3;  ///< of the tilt's variance that its earlier values leave

using Row = std::array<double, unknowns>;
using Square = std::array<Row, unknowns>;  // lower triangle

using Filter = std::array<double, order>;

/// Solves the Yule-Walker equations of the noise.
Filter autoregression(const std::vector<double>& noise) {
  std::array<double, order + 1> covariance{};
  for (std::size_t lag = 0; lag <= order; ++lag)
    for (std::size_t k = lag; k < noise.size(); ++k) covariance[lag] += noise[k] * noise[k - lag];
  std::array<Filter, order> left{};
  Filter a{};
  for (std::size_t i = 0; i < order; ++i) {
    for (std::size_t j = 0; j <= i; ++j) left[i][j] = covariance[i - j];
    left[i][i] *= 1.0 + 1e-9;
  }
  std::copy_n(covariance.begin() + 1, order, a.begin());
  solve(left, a);
  return a;
}

/// Returns the regressors of the sway at block `at`: the last tilts and a constant.
Row row_of(const std::vector<double>& tilt, double constant, std::size_t at) {
  Row row;
  for (std::size_t j = 0; j < taps; ++j) row[j] = tilt[at - j];
  row[taps] = constant;
  return row;
}

void add_products(const Row& row, Square& sums) {
  for (std::size_t i = 0; i < unknowns; ++i)
    for (std::size_t j = 0; j <= i; ++j) sums[i][j] += row[i] * row[j];
}

void add_products(const Row& row, double value, Row& sums) {
  for (std::size_t i = 0; i < unknowns; ++i) sums[i] += row[i] * value;
}

double constant_of(const Filter& a) {
  double constant = 1.0;
  for (const double value : a) constant -= value;
  return constant;
}

/// The sway minus its response, and the autoregression of this residual.
struct Rest {
  std::vector<double> noise;
  Filter a;
};

/// `shifted`: `rest` plus the blocks by which the tilt is read later. is_determined: the tilt's values determine its
/// later ones, so that noise would determine the response where the tilt begins to move.
Rest fit_response(const std::vector<double>& sway, const std::vector<double>& tilt, bool is_determined,
                  std::size_t shifted = rest) {
  Rest found{sway, {0.9}};
  for (int round = 0; round < rounds; ++round) {
    const std::vector<double> y = whitened(sway, found.a), u = whitened(tilt, found.a);
    Square left{};
    Row h{};
    for (std::size_t k = order; k < sway.size(); ++k) {
      const Row row = row_of(u, constant_of(found.a), k + shifted);
      add_products(row, left);
      add_products(row, y[k], h);
    }
    if (is_determined)
      for (std::size_t i = 0; i < unknowns; ++i) left[i][i] *= 1.0 + ridge;
    solve(left, h);
    for (std::size_t k = 0; k < sway.size(); ++k) {
      const Row row = row_of(tilt, 1.0, k + shifted);
      found.noise[k] = sway[k];
      for (std::size_t j = 0; j < unknowns; ++j) found.noise[k] -= h[j] * row[j];
    }
    found.a = autoregression(found.noise);
  }
  return found;
}

/// Fits with responses that begin later. y, u: whitened sway and tilt.
class DeadTimes {
 public:
  DeadTimes(const std::vector<double>& y, const std::vector<double>& u, double constant) : n_(y.size()) {
    const auto tilt = [&](std::size_t k, std::size_t lag) { return u[k + rest - lag]; };
    for (std::size_t k = order; k < n_; ++k) {
      size_ += y[k] * y[k];
      right_[reach] += y[k] * constant;
      for (std::size_t i = 0; i < reach; ++i) {
        right_[i] += y[k] * tilt(k, i);
        left_[i][0] += tilt(k, i) * tilt(k, 0);
        left_[reach][i] += tilt(k, i) * constant;
      }
    }
    left_[reach][reach] = static_cast<double>(n_ - order) * constant * constant;
    // One block earlier are the products of the taps before.
    for (std::size_t i = 1; i < reach; ++i)
      for (std::size_t j = 1; j <= i; ++j)
        left_[i][j] = left_[i - 1][j - 1] + tilt(order, i) * tilt(order, j) - tilt(n_, i) * tilt(n_, j);
  }

  /// Returns the residual of a response of taps first .. end - 1.
  double residual(std::size_t first, std::size_t end) const {
    Products left{};
    Taps right{};
    const auto is_used = [&](std::size_t i) { return i == reach || (i >= first && i < end); };
    for (std::size_t i = 0; i <= reach; ++i) {
      if (!is_used(i)) continue;
      right[i] = right_[i];
      for (std::size_t j = 0; j <= i; ++j)
        if (is_used(j)) left[i][j] = left_[i][j];
    }
    return size_ - eliminate(left, right);
  }

 private:
  static constexpr std::size_t reach = max_searched_dead + taps;
  static_assert(reach + order <= rest);
  using Taps = std::array<double, reach + 1>;  // with the constant
  using Products = std::array<Taps, reach + 1>;

  std::size_t n_;
  double size_ = 0.0;
  Products left_{};
  Taps right_{};
};

/// Returns the blocks before the sway begins to respond; 0 for a small response, and if it begins after
/// max_searched_dead.
std::size_t find_dead_time(const DeadTimes& dead_times, std::size_t blocks) {
  const auto gain = [&](double worse, double better) { return gain_of(blocks, worse, better); };
  const double no_response = dead_times.residual(0, 0);
  const double whole_gain = gain(no_response, dead_times.residual(0, max_searched_dead + taps));
  if (!(whole_gain > dead_gain)) return 0;
  // The taps before a dead time improve the fit by chance, and because the response is not linear.
  const double inexact_gain = std::min(inexact_part * whole_gain, max_inexact_gain);
  const auto is_needed = [&](std::size_t dead) {
    return gain(dead_times.residual(dead, dead + taps), dead_times.residual(0, dead + taps)) >
           std::max(chance_gain * static_cast<double>(dead) + chance_gain_more, inexact_gain);
  };
  std::size_t dead = 0;
  while (dead < max_searched_dead && !is_needed(dead + 1)) ++dead;
  return dead < max_searched_dead && gain(no_response, dead_times.residual(dead, dead + taps)) > dead_gain ? dead : 0;
}

/// Returns true if `Lags` tilts determine the tilt `dead` blocks after them, while it moves.
template <std::size_t Lags>
bool is_determined(const std::vector<double>& tilt, std::size_t dead) {
  const auto moves = [](double rest_rad) { return [rest_rad](double value) { return value != rest_rad; }; };
  const auto first = std::ranges::find_if(tilt, moves(tilt.front())) - tilt.begin();
  const auto behind = std::find_if(tilt.rbegin(), tilt.rend(), moves(tilt.back())) - tilt.rbegin();
  const std::size_t begin = static_cast<std::size_t>(first) + 1 + Lags + dead;
  const std::size_t end = tilt.size() - static_cast<std::size_t>(behind);
  if (end < begin + 4 * Lags) return false;
  double mean = 0.0;
  for (std::size_t k = begin; k < end; ++k) mean += tilt[k] / static_cast<double>(end - begin);
  std::array<std::array<double, Lags>, Lags> left{};
  std::array<double, Lags> right{};
  double size = 0.0;
  for (std::size_t k = begin; k < end; ++k) {
    const auto earlier = [&](std::size_t lag) { return tilt[k - dead - lag] - mean; };
    for (std::size_t i = 0; i < Lags; ++i) {
      for (std::size_t j = 0; j <= i; ++j) left[i][j] += earlier(i) * earlier(j);
      right[i] += earlier(i) * (tilt[k] - mean);
    }
    size += (tilt[k] - mean) * (tilt[k] - mean);
  }
  return size - eliminate(left, right) < determined_part * size;
}

}  // namespace

/// Fits in which the tilt is read later from a certain block. y, u: whitened sway and tilt.
class ResponseCheck::Slips {
 public:
  Slips(std::vector<double> y, std::vector<double> u, double constant)
      : y_(std::move(y)), u_(std::move(u)), constant_(constant), squares_(u_.size() + 1), before_(y_.size() + 1) {
    for (std::size_t s = 0; s < u_.size(); ++s) {
      squares_[s + 1] = squares_[s];
      if (s >= taps) add_products(row_of(u_, constant_, s), squares_[s + 1]);
    }
    for (std::size_t k = order; k < y_.size(); ++k) {
      size_ += y_[k] * y_[k];
      before_[k + 1] = before_[k];
      add_products(row_of(u_, constant_, k + rest), y_[k], before_[k + 1]);
    }
  }

  double without() const { return residual(y_.size(), rest, {}); }

  /// Calls visit(block, is_before, residual) for each place: the response is missing before the block, or from it on.
  template <class Visit>
  void visit_missing(const Visit& visit) const {
    const std::size_t end = y_.size();
    for (std::size_t k = margin; k + margin <= end; k += place_step) {
      const Square &here = squares_[k + rest], &all = squares_[end + rest], &first = squares_[order + rest];
      for (const bool is_before : {true, false}) {
        const Square &from = is_before ? here : first, &to = is_before ? all : here;
        Square left;
        Row right;
        for (std::size_t i = 0; i < unknowns; ++i) {
          for (std::size_t j = 0; j <= i; ++j) left[i][j] = to[i][j] - from[i][j];
          right[i] = is_before ? before_[end][i] - before_[k][i] : before_[k][i];
        }
        // The constant holds without a response too.
        left[taps][taps] = all[taps][taps] - first[taps][taps];
        right[taps] = before_[end][taps];
        visit(k, is_before, size_ - eliminate(left, right));
      }
    }
  }

  /// Calls visit(block, residual) for each place, from last to first. Returns the residual if the tilt is read later
  /// from the first block on. `shifted`: `rest` plus the blocks by which the tilt is read later.
  template <class Visit>
  double visit(std::size_t shifted, const Visit& visit) const {
    Row behind{};
    for (std::size_t k = y_.size(); k-- > order;) {
      add_products(row_of(u_, constant_, k + shifted), y_[k], behind);
      if (k >= margin && k <= y_.size() - margin && (k - margin) % place_step == 0)
        visit(k, residual(k, shifted, behind));
    }
    return residual(order, shifted, behind);
  }

 private:
  double residual(std::size_t place, std::size_t shifted, const Row& behind) const {
    const Square &from = squares_[order + rest], &to = squares_[place + rest], &from_there = squares_[place + shifted],
                 &end = squares_[y_.size() + shifted];
    Square left;
    Row right;
    for (std::size_t i = 0; i < unknowns; ++i) {
      for (std::size_t j = 0; j <= i; ++j) left[i][j] = to[i][j] - from[i][j] + end[i][j] - from_there[i][j];
      right[i] = before_[place][i] + behind[i];
    }
    return size_ - eliminate(left, right);
  }

  std::vector<double> y_, u_;
  double constant_, size_ = 0.0;
  std::vector<Square> squares_;  // [s]: sums of products before block s of the tilt
  std::vector<Row> before_;      // [k]: with the sway, before block k of the trial
};

ResponseCheck::ResponseCheck(std::span<const double> tilt_rad, double rate_hz, bool has_passive)
    : block_(std::max<std::size_t>(1, static_cast<std::size_t>(std::round(rate_hz / coarse_hz)))),
      step_s_(static_cast<double>(block_) / rate_hz),
      tilt_(rest, 0.0),
      blocks_(tilt_rad.size() / block_),
      typical_dead_(has_passive ? passive_dead : active_dead),
      max_dead_(has_passive ? max_passive_dead : max_active_dead) {
  const std::vector<double> means = block_means(tilt_rad, block_);
  tilt_.insert(tilt_.end(), means.begin(), means.end());
  tilt_.resize(tilt_.size() + max_slip, 0.0);
  is_sine_ = is_determined<2>(tilt_, max_dead_ + 1);
  is_determined_ = is_sine_ || is_determined<taps>(tilt_, max_dead_ + 1);
  if (is_determined_) max_dead_ += more_dead;
}

bool ResponseCheck::is_short() const {
  return static_cast<double>(blocks_) * step_s_ < min_trial_s || blocks_ < 3 * margin;
}

ResponseCheck::Found ResponseCheck::check(std::span<const double> sway_rad, std::span<const SampleRange> gaps) const {
  Found found;
  if (is_short()) return found;
  std::vector<double> sway = block_means(sway_rad, block_);
  double mean = 0.0;  // subtract_mean() would change the last bits of the results
  for (const double value : sway) mean += value / static_cast<double>(blocks_);
  for (double& value : sway) value -= mean;
  const Rest fit = fit_response(sway, tilt_, is_determined_);

  std::vector<bool> is_measured(gaps.empty() ? 0 : blocks_, true);
  for (const SampleRange& gap : gaps)
    for (std::size_t k = gap.first / block_; k < blocks_ && k * block_ < gap.end; ++k) is_measured[k] = false;
  found.movement = find_movement(fit.noise, fit.a, is_measured, step_s_);
  find_innovation(whitened(fit.noise, fit.a), found);

  if (is_sine_) return found;
  const std::vector<double> y = whitened(sway, fit.a), u = whitened(tilt_, fit.a);
  const Slips slips(y, u, constant_of(fit.a));
  const double plain = slips.without();
  find_slip(slips, plain, found);
  find_rest(slips, plain, found);
  if (const std::size_t dead = find_dead_time(DeadTimes(y, u, constant_of(fit.a)), blocks_); dead > max_dead_)
    found.early_s = static_cast<double>(dead - typical_dead_) * step_s_;
  return found;
}

void ResponseCheck::find_innovation(std::vector<double> innovations, Found& found) const {
  innovations.erase(innovations.begin(), innovations.begin() + order);
  for (double& value : innovations) value = std::abs(value);
  const auto largest = std::ranges::max_element(innovations);
  found.innovation_rad = *largest;
  found.innovation_at_s =
      static_cast<double>(largest - innovations.begin() + static_cast<std::ptrdiff_t>(order)) * step_s_;
  const double typical = median(std::move(innovations));
  found.medians = typical > 0.0 ? found.innovation_rad / typical : 0.0;
}

void ResponseCheck::find_slip(const Slips& slips, double plain, Found& found) const {
  double best = plain, best_shifted = plain;
  for (std::size_t shifted = rest - max_slip; shifted <= rest + max_slip; shifted += slip_step) {
    if (shifted == rest) continue;
    const double shift_s = (static_cast<double>(shifted) - static_cast<double>(rest)) * step_s_;
    const double whole = slips.visit(shifted, [&](std::size_t place, double residual) {
      if (!(residual < best)) return;
      best = residual;
      found.slip_s = shift_s;
      found.slip_at_s = static_cast<double>(place) * step_s_;
    });
    if (!(whole < best_shifted)) continue;
    best_shifted = whole;
    found.shift_s = shift_s;
  }
  found.slip_gain = gain_of(blocks_, plain, best);
  found.shift_gain = gain_of(blocks_, plain, best_shifted);
}

void ResponseCheck::find_rest(const Slips& slips, double plain, Found& found) const {
  double best = plain;
  slips.visit_missing([&](std::size_t place, bool is_before, double residual) {
    if (!(residual < best)) return;
    best = residual;
    found.rest_begin_s = is_before ? 0.0 : static_cast<double>(place) * step_s_;
    found.rest_end_s = static_cast<double>(is_before ? place : blocks_) * step_s_;
  });
  found.rest_gain = gain_of(blocks_, plain, best);
}

std::vector<double> ResponseCheck::centred_blocks(std::span<const double> signal_rad) const {
  if (is_short()) return {};
  std::vector<double> signal = block_means(signal_rad, block_);
  subtract_mean(signal);
  constexpr double rounding_rad = 1e-12;  // a constant's rounding errors are smaller
  if (std::ranges::all_of(signal, [](double value) { return std::abs(value) < rounding_rad; })) return {};
  return signal;
}

std::size_t ResponseCheck::shifted_by(double shift_s) const {
  constexpr auto max_shift = static_cast<double>(max_slip);
  return static_cast<std::size_t>(static_cast<double>(rest) +
                                  std::clamp(std::round(shift_s / step_s_), -max_shift, max_shift));
}

ResponseCheck::Response ResponseCheck::response_of(std::span<const double> signal_rad, double shift_s) const {
  const std::vector<double> signal = centred_blocks(signal_rad);
  if (signal.empty()) return {};
  const Rest fit = fit_response(signal, tilt_, is_determined_, shifted_by(shift_s));
  std::vector<double> response(signal.size());
  for (std::size_t k = 0; k < signal.size(); ++k) response[k] = signal[k] - fit.noise[k];
  subtract_mean(response);
  const auto power = [](const std::vector<double>& values, std::size_t first) {
    double sum = 0.0;
    for (std::size_t k = first; k < values.size(); ++k) sum += values[k] * values[k];
    return sum;
  };
  const double rest_power = power(whitened(fit.noise, fit.a), order), all = power(whitened(signal, fit.a), order);
  return {gain_of(signal.size(), all, rest_power), std::sqrt(power(response, 0) / static_cast<double>(signal.size()))};
}

Prediction ResponseCheck::prediction_of(std::span<const double> signal_rad, double shift_s) const {
  const std::vector<double> signal = centred_blocks(signal_rad);
  return signal.empty() ? Prediction{} : predict(signal, tilt_, shifted_by(shift_s));
}

}  // namespace decid::recording
