// Draws of one quantity in numbers.
#pragma once

#include <span>
#include <vector>

namespace decid::posterior {

double mean(std::span<const double> draws);
/// Standard deviation.
double deviation(std::span<const double> draws);
/// The value that this share of the draws is below, straight between them.
double quantile(std::vector<double> draws, double share);
/// The same, of draws in ascending order.
double quantile_of_sorted(std::span<const double> draws, double share);
/// Of two quantities; 0 if one of them is the same in all draws.
double correlation(std::span<const double> a, std::span<const double> b);

}  // namespace decid::posterior
