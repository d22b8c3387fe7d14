// Means, standard deviations, quantiles, correlations and standardised differences of values in memory, in double
// precision, summed in the order of the values. No values: NaN for a mean, undefined for the others.
#pragma once

#include <span>
#include <vector>

namespace decid {

double mean(std::span<const double> values);
double mean(std::span<const float> values);
void subtract_mean(std::span<double> values);
/// Standard deviation about the mean, divided by n.
double stddev(std::span<const double> values);
/// Variance about the mean, divided by n - 1.
double sample_variance(std::span<const double> values);
/// Returns the value at place n / 2 in ascending order: the upper median of an even number of values.
double median(std::vector<double> values);
/// Returns the standard deviation of normal deviates with these absolute values, by the median of the latter.
double stddev_by_median(std::vector<double> sizes);
/// Returns the value that this fraction of the values lies below, interpolated linearly between neighbours.
double quantile(std::vector<double> values, double fraction);
/// As quantile(), of values in ascending order.
double quantile_of_sorted(std::span<const double> values, double fraction);
/// Pearson's correlation of two series of equal length; 0 if one of them is constant.
double correlation(std::span<const double> a, std::span<const double> b);
/// Returns Hedges' g of a difference of means, J difference / sd, with sd on f degrees of freedom. J = 1 - 3 / (4 f -
/// 1) takes out the bias of small samples, to 0.0004 from f = 10 on. NaN where sd is 0 or f < 2. L. Hedges, J. Educ.
/// Stat. 6 (1981) 107-128.
double hedges_g(double difference, double sd, double degrees_of_freedom);

}  // namespace decid
