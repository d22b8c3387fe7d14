// Distributions over parameters: see distribution.hpp.
#include "identify/network/distribution.hpp"

#include <utility>

#include "base/error.hpp"
#include "base/text.hpp"

namespace decid {

ParameterDistribution::ParameterDistribution(Mixture mixture, const sim::ParameterTable& table,
                                             Recalibration recalibration)
    : mixture_(std::move(mixture)), low_(table.size()), range_(table.size()), recalibration_(std::move(recalibration)) {
  const std::size_t recalibrated = recalibration_.known() ? recalibration_.levels.size() : table.size();
  if (mixture_.parameters() != table.size() || recalibrated != table.size())
    throw Error(Code::size_mismatch, "distribution",
                format("of %zu parameters, %zu of them recalibrated, where there are %zu", mixture_.parameters(),
                       recalibrated, table.size()),
                "give those of the same model");
  for (std::size_t p = 0; p < table.size(); ++p) {
    low_[p] = table[p].low;
    range_[p] = table[p].range();
  }
}

double ParameterDistribution::mean(int quantity) const {
  const auto p = static_cast<std::size_t>(quantity);
  return low_[p] + range_[p] * mixture_.mean(p);
}

double ParameterDistribution::stddev(int quantity) const {
  const auto p = static_cast<std::size_t>(quantity);
  return range_[p] * mixture_.stddev(p) * recalibration_.factor(p);
}

double ParameterDistribution::quantile(int quantity, double probability) const {
  const auto p = static_cast<std::size_t>(quantity);
  return low_[p] + range_[p] * mixture_.quantile(p, recalibration_.level(p, probability));
}

double ParameterDistribution::below(int quantity, double value) const {
  const auto p = static_cast<std::size_t>(quantity);
  return recalibration_.probability(p, mixture_.below(p, fraction_of(p, value)));
}

double ParameterDistribution::correlation(int a, int b) const {
  return mixture_.correlation(static_cast<std::size_t>(a), static_cast<std::size_t>(b));
}

double ParameterDistribution::log_density(int quantity, double value) const {
  const auto p = static_cast<std::size_t>(quantity);
  return mixture_.log_density(p, fraction_of(p, value));
}

double ParameterDistribution::log_density(const sim::Parameters& values) const {
  if (values.size() != parameters())
    throw Error(Code::size_mismatch, "distribution",
                format("%zu values for %zu parameters", values.size(), parameters()), "give one for each");
  std::vector<double> fractions;
  for (std::size_t p = 0; p < values.size(); ++p) fractions.push_back(fraction_of(p, values[p]));
  return mixture_.log_density(fractions);
}

}  // namespace decid
