// Statistics of one quantity's draws.
#pragma once

#include <span>
#include <vector>

namespace decid::posterior {

double mean(std::span<const double> draws);
/// Returns the standard deviation.
double deviation(std::span<const double> draws);
/// Returns the quantile at `probability`, linear between draws.
double quantile(std::vector<double> draws, double probability);
/// Returns the same for draws in ascending order.
double quantile_of_sorted(std::span<const double> draws, double probability);
/// Returns the correlation of two quantities; 0 if one of them is constant.
double correlation(std::span<const double> a, std::span<const double> b);

}  // namespace decid::posterior
