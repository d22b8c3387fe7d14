// Prediction of a signal by the tilt: see prediction.hpp.
#include "recording/quality/detail/prediction.hpp"

#include <algorithm>
#include <array>

#include "recording/quality/detail/least_squares.hpp"

namespace decid::recording {
namespace {

/// Unknowns: a and c; with h; with the delay and the clock's error.
constexpr std::size_t own = own_lags + 1, with_tilt = own + tilt_lags, with_clock = with_tilt + 2;

template <std::size_t N>
using Row = std::array<double, N>;
template <std::size_t N>
using Square = std::array<Row<N>, N>;  // lower triangle

Row<with_tilt> regressors(const std::vector<double>& signal, const std::vector<double>& tilt, std::size_t first,
                          std::size_t k) {
  Row<with_tilt> row;
  for (std::size_t i = 0; i < own_lags; ++i) row[i] = signal[k - 1 - i];
  row[own_lags] = 1.0;
  for (std::size_t j = 0; j < tilt_lags; ++j) row[own + j] = tilt[first + k - j];
  return row;
}

/// Returns the squared error left when the first `unknowns` are fitted; `explained`: as eliminate() leaves it.
template <std::size_t N>
double error_of(double squares, const Row<N>& explained, std::size_t unknowns) {
  for (std::size_t i = 0; i < unknowns; ++i) squares -= explained[i] * explained[i];
  return squares;
}

}  // namespace

Prediction predict(const std::vector<double>& signal, const std::vector<double>& tilt, std::size_t first) {
  const std::size_t blocks = signal.size();
  Square<with_tilt> left{};
  Row<with_tilt> right{};
  double squares = 0.0;
  std::vector<Row<with_tilt>> rows;  // of the blocks from own_lags
  rows.reserve(blocks);
  for (std::size_t k = own_lags; k < blocks; ++k) {
    const Row<with_tilt> row = regressors(signal, tilt, first, k);
    for (std::size_t i = 0; i < with_tilt; ++i) {
      right[i] += row[i] * signal[k];
      for (std::size_t j = 0; j <= i; ++j) left[i][j] += row[i] * row[j];
    }
    squares += signal[k] * signal[k];
    rows.push_back(row);
  }
  Row<with_tilt> fitted = right;
  solve(left, fitted);

  // The response's part of a block changes with a delay by its slope, and with a wrong clock by its slope times time.
  Square<with_clock> more{};
  Row<with_clock> more_right{};
  for (std::size_t i = 0; i < with_tilt; ++i) {
    std::copy_n(left[i].begin(), i + 1, more[i].begin());
    more_right[i] = right[i];
  }
  for (std::size_t k = own_lags; k < blocks; ++k) {
    const Row<with_tilt>& row = rows[k - own_lags];
    double slope = 0.0;
    for (std::size_t j = 0; j < tilt_lags; ++j) slope += fitted[own + j] * (row[own + j] - tilt[first + k - j - 1]);
    const Row<2> added{slope, slope * (static_cast<double>(k) - 0.5 * static_cast<double>(blocks))};
    for (std::size_t a = 0; a < added.size(); ++a) {
      Row<with_clock>& sums = more[with_tilt + a];
      for (std::size_t i = 0; i < with_tilt; ++i) sums[i] += added[a] * row[i];
      for (std::size_t b = 0; b <= a; ++b) sums[with_tilt + b] += added[a] * added[b];
      more_right[with_tilt + a] += added[a] * signal[k];
    }
  }
  eliminate(more, more_right);
  const double of_own = error_of(squares, more_right, own), of_tilt = error_of(squares, more_right, with_tilt),
               delayed = error_of(squares, more_right, with_tilt + 1),
               of_all = error_of(squares, more_right, with_clock);
  constexpr double rounding = 1e-9;  // of a signal that its own past determines
  if (of_own < rounding * squares) return {};
  return {gain_of(blocks, of_own, of_tilt), gain_of(blocks, delayed, of_all),
          more_right[with_clock - 1] * more[with_clock - 1][with_clock - 1]};
}

}  // namespace decid::recording
