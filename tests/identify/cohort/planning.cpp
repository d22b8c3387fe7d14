// The uncertainty of recordings of a planned study: the built-in network on simulated recordings, and fits.
#include "identify/cohort/planning.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <tuple>

#include "base/error.hpp"
#include "sim/body_model.hpp"
#include "tests/helpers.hpp"

using decid::Code;
using decid::cohort::PlannedGroups;
using decid::cohort::spread_of_fits;
using decid::cohort::spread_of_network;
using decid::cohort::ValueSpread;
using decid::test::check_error;
using decid::test::error_of;

namespace {

PlannedGroups later_in_the_middle(const decid::sim::ParameterTable& table) {
  PlannedGroups groups{table.middle(), decid::sim::Parameters(table.size()), decid::sim::Parameters(table.size())};
  for (std::size_t p = 0; p < table.size(); ++p) groups.participant_sd[p] = table[p].range() / 10.0;
  groups.difference[decid::sim::Delay] = 0.02;
  return groups;
}

}  // namespace

TEST_CASE("cohort: more measurement noise makes a network's values less certain") {
  const decid::Model model = decid::built_in_model();
  PlannedGroups groups = later_in_the_middle(model.parameters());
  decid::sim::Protocol quiet = model.protocol, noisy = model.protocol;
  quiet.noise.sensor = {0.01, 0.01};
  noisy.noise.sensor = {0.2, 0.2};
  const ValueSpread little = spread_of_network(model, quiet, groups, 40, 1);
  const ValueSpread much = spread_of_network(model, noisy, groups, 40, 1);
  CHECK(much.measurement_sd[decid::sim::Delay] > 1.2 * little.measurement_sd[decid::sim::Delay]);
  CHECK(little.measurement_sd[decid::sim::Delay] > 0.004);
  CHECK(little.measurement_sd[decid::sim::Delay] < 0.05);
  CHECK(little.participant_sd[decid::sim::Delay] > 0.5 * groups.participant_sd[decid::sim::Delay]);
  CHECK(little.measurement_sd[decid::sim::Kp] == 0.0);  // no difference
  CHECK(spread_of_network(model, quiet, groups, 40, 1).measurement_sd == little.measurement_sd);

  check_error([&] { (void)spread_of_network(model, quiet, groups, 1, 1); }, Code::setting_out_of_range);
  PlannedGroups outside = groups;
  outside.difference[decid::sim::Delay] = 0.3;
  check_error([&] { (void)spread_of_network(model, quiet, outside, 40, 1); }, Code::setting_out_of_range);
  const double mgh = model.protocol.experiment.body.mgh();
  check_error([&] { decid::cohort::check_means(model.parameters(), outside, mgh); }, Code::setting_out_of_range);
  outside = groups;
  outside.at[decid::sim::Kp] = 0.9;
  check_error([&] { decid::cohort::check_means(model.parameters(), outside, mgh); }, Code::setting_out_of_range,
              "0.9 m g h is 755");
  decid::cohort::check_means(model.parameters(), groups, mgh);
  const decid::sim::ParameterInfo& kp = model.parameters()[decid::sim::Kp];
  for (const double value : {0.0, 2.5, 4.0, 30.0}) CHECK(decid::cohort::hint_of_unit(kp, value, mgh).empty());
  CHECK_FALSE(decid::cohort::hint_of_unit(kp, -2.0, mgh).empty());
  CHECK(decid::cohort::hint_of_unit(model.parameters()[decid::sim::Delay], 0.001, mgh).empty());
  // The second group's mean, and means for which no unit is wanted, have no hint.
  for (const auto& [at, difference, unit] : {std::tuple{800.0, -799.0, mgh}, {0.9, 0.0, 0.0}})
    CHECK(error_of([&, a = at, d = difference, u = unit] { decid::cohort::check_mean(kp, a, d, u); })
              .remedy()
              .find("m g h") == std::string::npos);
  // The network shows nothing of a difference that is far below its noise, or shows it with the wrong sign.
  PlannedGroups backwards = groups;
  backwards.difference = decid::sim::Parameters(groups.at.size());
  backwards.difference[decid::sim::Kp_pass] = 1e-9 * model.parameters()[decid::sim::Kp_pass].range();
  backwards.difference[decid::sim::Kp] = 0.25 * model.parameters()[decid::sim::Kp].range();
  check_error([&] { (void)spread_of_network(model, noisy, backwards, 8, 1); }, Code::value_invalid);
}

TEST_CASE("cohort: fits of quieter recordings differ less") {
  const decid::sim::Protocol protocol = decid::sim::short_protocol();
  const PlannedGroups groups = later_in_the_middle(protocol.ranges());
  const ValueSpread little = spread_of_fits(protocol, {}, groups, 0.01, 8, 1);
  const ValueSpread much = spread_of_fits(protocol, {}, groups, 0.1, 8, 1);
  CHECK(little.participant_sd == groups.participant_sd);
  CHECK(much.measurement_sd[decid::sim::Delay] > 1.3 * little.measurement_sd[decid::sim::Delay]);
  CHECK(much.measurement_sd[decid::sim::Kp_pass] > little.measurement_sd[decid::sim::Kp_pass]);
  check_error([&] { (void)spread_of_fits(protocol, {}, groups, 0.0, 8, 1); }, Code::setting_out_of_range);
}

TEST_CASE("cohort: fits do not measure a parameter that they fix") {
  const decid::sim::Protocol protocol = decid::sim::short_protocol();
  const PlannedGroups groups = later_in_the_middle(protocol.ranges());
  const decid::posterior::Priors priors{.parameters = {{.name = "Kp", .fixed = groups.at[decid::sim::Kp]}}};
  const ValueSpread spread = spread_of_fits(protocol, priors, groups, 0.02, 8, 1);
  CHECK(std::isnan(spread.measurement_sd[decid::sim::Kp]));
  CHECK(spread.measurement_sd[decid::sim::Delay] > 0.0);
}
