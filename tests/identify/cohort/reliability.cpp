// Reliability of visits: the published example of Shrout and Fleiss. The intervals are those of R's irr::icc, whose
// published formulas were written down again in mpmath with 40 digits.
#include "identify/cohort/reliability.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/math/random.hpp"
#include "tests/helpers.hpp"
#include "tests/near.hpp"

using decid::Code;
using decid::cohort::Reliability;
using decid::cohort::reliability;
using namespace decid::test;

TEST_CASE("reliability: Shrout and Fleiss 1979, table 2") {
  const std::vector<double> values{9, 2, 5, 8, 6, 1, 3, 2, 8, 4, 6, 8, 7, 1, 2, 6, 10, 5, 6, 9, 6, 2, 4, 7};
  const Reliability found = reliability(4, values);
  CHECK(found.participants == 6);
  CHECK(near(found.icc_single, 184.0 / 635.0, 1e-12));
  CHECK(near(found.icc_average, 736.0 / 1187.0, 1e-12));
  CHECK(near(found.icc_single95[0], 0.0187865133747119876, 1e-10));
  CHECK(near(found.icc_single95[1], 0.761084369648952894, 1e-10));
  CHECK(near(found.icc_average95[0], 0.0394401799213909962, 1e-10));
  CHECK(near(found.icc_average95[1], 0.928573183377168136, 1e-10));
  CHECK(near(found.standard_error, 2.50277623628020108, 1e-12));
  CHECK(near(found.minimal_detectable_change, 6.93721431470444772, 1e-12));
}

TEST_CASE("reliability: two visits of five persons, split into measurement and person") {
  const std::vector<double> values{812, 830, 905, 880, 777, 790, 860, 845, 930, 955};
  const Reliability found = reliability(2, values, std::vector<double>(10, 100.0));
  CHECK(near(found.icc_single, 0.949497023198521864, 1e-12));
  CHECK(near(found.icc_average, 0.97409435551811289, 1e-12));
  CHECK(near(found.icc_single95[0], 0.606713569530367602, 1e-10));
  CHECK(near(found.icc_average95[0], 0.755461713201286595, 1e-10));
  CHECK(near(found.icc_average95[1], 0.997300447485400182, 1e-10));
  CHECK(near(found.minimal_detectable_change, 42.9048606439483166, 1e-12));
  CHECK(near(found.standard_error * found.standard_error - found.visit_sd * found.visit_sd,
             found.measurement_sd * found.measurement_sd + found.within_participant_sd * found.within_participant_sd,
             1e-11));
  CHECK(found.measurement_sd == 10.0);
  CHECK(reliability(2, values, std::vector<double>(10, 1e4)).within_participant_sd == 0.0);
}

// 4,000 studies of 20 persons, two visits each. A coverage of 0.95 has a standard error of 0.0034, changes of persons
// have one of 0.0008: bounds are four of them, and more for the interval, which is approximate. Fewer than 5% exceed
// the detectable change, because it also counts what visits differ by chance.
TEST_CASE("reliability: intervals hold the true correlation, and few unchanged persons exceed the detectable change") {
  const decid::Random random(33, decid::Stream::user, 0);
  std::uint64_t used = 0;
  constexpr int studies = 4000, persons = 20;
  for (const double icc : {0.3, 0.6, 0.9}) {
    CAPTURE(icc);
    int held = 0, exceeded = 0;
    for (int study = 0; study < studies; ++study) {
      std::vector<double> values;
      for (int person = 0; person < persons; ++person) {
        const double own = std::sqrt(icc) * random.normal(used++);
        for (int visit = 0; visit < 2; ++visit) values.push_back(own + std::sqrt(1.0 - icc) * random.normal(used++));
      }
      const Reliability found = reliability(2, values);
      held += found.icc_single95[0] <= icc && icc <= found.icc_single95[1] ? 1 : 0;
      for (std::size_t i = 0; i < values.size(); i += 2)
        exceeded += std::abs(values[i + 1] - values[i]) > found.minimal_detectable_change ? 1 : 0;
    }
    CHECK(within(held / double{studies}, 0.95, 0.02));
    CHECK(within(exceeded / (double{studies} * persons), 0.044, 0.0035));
  }
}

// irr has -18.8 to -18.4 for an ICC of -16.8 in the first of these studies.
TEST_CASE("reliability: an interval holds its estimate, or is unknown") {
  const Reliability two = reliability(2, std::vector<double>{10, 14, 13, 10.5});
  CHECK(near(two.icc_single, -16.8, 1e-12));
  for (const double end : two.icc_single95) CHECK(std::isnan(end));
  const Reliability four = reliability(2, std::vector<double>{1, 3, 2.5, 1, 2, 2.2, 1.8, 2.1});
  CHECK(near(four.icc_single, -1.58649, 1e-5));
  CHECK(near(four.icc_single95[0], -1.78198, 1e-5));
  CHECK(near(four.icc_single95[1], -0.137452, 1e-5));
  const decid::Random random(34, decid::Stream::user, 0);
  std::uint64_t used = 0;
  int unknown = 0;
  constexpr int studies = 2000;
  for (int study = 0; study < studies; ++study) {
    std::vector<double> values(2 * (2 + static_cast<std::size_t>(study) % 4));
    for (double& value : values) value = random.normal(used++);
    const Reliability found = reliability(2, values);
    for (const auto& [estimate, ends] :
         {std::pair{found.icc_single, found.icc_single95}, std::pair{found.icc_average, found.icc_average95}}) {
      CHECK((std::isnan(ends[0]) || (ends[0] <= estimate + 1e-6 && estimate <= ends[1] + 1e-6)));
      unknown += std::isnan(ends[0]) ? 1 : 0;
    }
  }
  CHECK(unknown > 0);
  CHECK(unknown < studies / 4);
}

TEST_CASE("reliability: visits that agree exactly have a reliability of 1") {
  const Reliability found = reliability(2, std::vector<double>{1, 1, 2, 2, 3, 3});
  CHECK(found.icc_single == 1.0);
  CHECK(found.icc_average95[0] == 1.0);
  CHECK(found.minimal_detectable_change == 0.0);
}

TEST_CASE("reliability: there is no interval if everybody changes by the same amount") {
  const Reliability found = reliability(2, std::vector<double>{1, 1.5, 2, 2.5, 3, 3.5, 4, 4.5});
  CHECK(found.icc_single > 0.8);
  CHECK(found.icc_single < 1.0);
  for (const double end :
       {found.icc_single95[0], found.icc_single95[1], found.icc_average95[0], found.icc_average95[1]})
    CHECK(std::isnan(end));
  CHECK(found.visit_sd > 0.0);
  const Reliability alike = reliability(2, std::vector<double>{1, 2, 1, 2, 1, 2});  // persons do not differ either
  CHECK(std::isnan(alike.icc_single95[0]));
}

TEST_CASE("reliability: tables that cannot be used are refused") {
  const std::vector<double> values{1, 2, 3, 4};
  check_error([&] { (void)reliability(1, values); }, Code::size_mismatch);
  check_error([&] { (void)reliability(4, values); }, Code::size_mismatch);
  check_error([&] { (void)reliability(3, values); }, Code::size_mismatch);
  check_error([&] { (void)reliability(0, values); }, Code::size_mismatch);
  check_error([&] { (void)reliability(2, values, std::vector<double>{1.0}); }, Code::size_mismatch);
  check_error([&] { (void)reliability(2, std::vector<double>{2, 2, 2, 2}); }, Code::value_invalid);
  check_error([&] { (void)reliability(2, std::vector<double>{2, 1, std::nan(""), 2}); }, Code::value_invalid);
}

TEST_CASE("reliability: the mean of visits has none where its estimated variance is not positive") {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  // Visits that disagree in everybody: the quotients would be 5.2 and 4.2.
  const Reliability found = reliability(2, std::vector<double>{1.0, 3.0, 2.2, 0.9, 3.1, 1.2, 0.8, 2.9});
  CHECK(near(found.icc_single, -1.62141491395793513, 1e-12));
  CHECK(near(found.icc_single95[0], -1.90836657155772112, 1e-10));
  CHECK(found.icc_average == -infinity);
  CHECK(found.icc_average95[0] == -infinity);
  CHECK(near(found.icc_average95[1], -0.158939638702160794, 1e-9));
  CHECK(found.shown_fraction == 1.0);
  // Three persons in two sessions, who differ less than their sessions: 9.3 and 3.3.
  const Reliability few = reliability(2, std::vector<double>{3036, 3293, 2571, 3089, 3341, 2173});
  CHECK(few.icc_average == -infinity);
  CHECK(few.icc_average95[0] == -infinity);
  CHECK(near(few.icc_average95[1], 0.920498677107653925, 1e-9));
  // An ordinary table whose lower end is far below 0 keeps it.
  const Reliability loose = reliability(2, std::vector<double>{2362, 2526, 3442, 3193, 2906, 2057});
  CHECK(near(loose.icc_average95[0], -2.80938890558116285, 1e-9));
  // Two persons who swap: one visit has none either.
  const Reliability swapped = reliability(2, std::vector<double>{1, 2, 2, 1});
  CHECK(swapped.icc_single == -infinity);
  CHECK(swapped.icc_average == -infinity);
}
