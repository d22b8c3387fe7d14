// The uncertainty of recordings of a planned study: the built-in model on simulated recordings.
#include "identify/cohort/planning.hpp"

#include <doctest/doctest.h>

#include "base/error.hpp"
#include "sim/body_model.hpp"
#include "tests/helpers.hpp"

using decid::Code;
using decid::cohort::measurement_sd;
using decid::test::check_error;

TEST_CASE("cohort: more measurement noise makes recordings less certain") {
  const decid::Model model = decid::built_in_model();
  const decid::sim::Parameters at = model.parameters().middle();
  decid::sim::Parameters person_sd(at.size());
  for (std::size_t p = 0; p < at.size(); ++p) person_sd[p] = model.parameters()[p].range() / 10.0;
  decid::sim::Protocol quiet = model.protocol, noisy = model.protocol;
  quiet.noise.sensor = {0.01, 0.01};
  noisy.noise.sensor = {0.2, 0.2};
  const decid::sim::Parameters little = measurement_sd(model, quiet, at, person_sd, 40, 1);
  const decid::sim::Parameters much = measurement_sd(model, noisy, at, person_sd, 40, 1);
  CHECK(much[decid::sim::Delay] > 1.2 * little[decid::sim::Delay]);
  CHECK(little[decid::sim::Delay] > 0.004);
  CHECK(little[decid::sim::Delay] < 0.05);
  CHECK(measurement_sd(model, quiet, at, person_sd, 40, 1) == little);

  check_error([&] { (void)measurement_sd(model, quiet, at, person_sd, 0, 1); }, Code::setting_out_of_range);
  decid::sim::Parameters outside = at;
  outside[decid::sim::Delay] = 0.3;
  check_error([&] { (void)measurement_sd(model, quiet, outside, person_sd, 40, 1); }, Code::setting_out_of_range);
}
