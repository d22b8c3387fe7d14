// Tests of sim/segments.hpp: Winter's segments give the default body to the digits it is printed with.
#include "sim/segments.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <utility>

#include "base/error.hpp"
#include "tests/helpers.hpp"

using namespace decid::sim;
using decid::test::check_error;
using decid::test::near;

namespace {

// Products of up to seven factors on each side, each rounded to eps / 2.
constexpr double rounding = 7.0 * std::numeric_limits<double>::epsilon();

}  // namespace

TEST_CASE("segments: the default body is that of 88.86 kg and 1.80 m, to its printed digits") {
  const Body body = make_body(make_segments({.mass_kg = 88.86, .height_m = 1.80}));
  const Body printed;
  // Half a unit in the last printed place.
  CHECK(std::abs(body.mass_kg - printed.mass_kg) <= 0.0005);
  CHECK(std::abs(body.com_height_m - printed.com_height_m) <= 0.000005);
  CHECK(std::abs(body.inertia_kgm2 - printed.inertia_kgm2) <= 0.0005);
  // The product has the relative errors of both.
  CHECK(std::abs(body.mgh() - printed.mgh()) <= printed.mgh() * (0.0005 / 86.283 + 0.000005 / 0.99119));
}

TEST_CASE("segments: each number by hand") {
  const Segments s = make_segments({.mass_kg = 100.0, .height_m = 2.0});
  CHECK(near(s.leg_mass_kg, 29.3, rounding));
  CHECK(near(s.leg_length_m, 0.982, rounding));
  CHECK(near(s.leg_com_m, 0.543046, rounding));
  CHECK(near(s.leg_inertia_kgm2, 29.3 * 0.320132 * 0.320132, rounding));
  CHECK(near(s.trunk_mass_kg, 67.8, rounding));
  CHECK(near(s.trunk_com_m, 0.360576, rounding));
  CHECK(near(s.trunk_inertia_kgm2, 67.8 * 0.33728 * 0.33728, rounding));
  CHECK(near(s.trunk_mgh(), 67.8 * 9.81 * 0.360576, rounding));
  CHECK(near(s.mass_kg(), 97.1, rounding));
}

TEST_CASE("segments: a body's subject") {
  const Participant participant = make_participant(make_body(make_segments({.mass_kg = 61.3, .height_m = 1.67})));
  CHECK(near(participant.mass_kg, 61.3, rounding));
  CHECK(near(participant.height_m, 1.67, rounding));
  const Participant standard = make_participant(Body{});
  CHECK(std::abs(standard.mass_kg - 88.86) < 0.0005 / 0.971);
  CHECK(std::abs(standard.height_m - 1.80) < 0.000005 / 0.55);
  Body heavy;
  heavy.inertia_kgm2 = 103.0;
  check_error([&] { make_participant(heavy); }, decid::Code::setting_conflict);
}

TEST_CASE("segments: bounds") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double mass : {0.0, -1.0, 501.0, nan})
    check_error([&] { make_segments({mass, 1.8}); }, decid::Code::setting_out_of_range, "mass_kg");
  for (const double height : {0.0, -1.0, 3.1, nan})
    check_error([&] { make_segments({80.0, height}); }, decid::Code::setting_out_of_range, "height_m");
  for (const auto& height : {std::pair(175.0, "1.75"), std::pair(162.5, "1.625")})
    check_error([&] { make_segments({80.0, height.first}); }, decid::Code::setting_out_of_range, height.second);
}

TEST_CASE("a person's body has a person's weight and height") {
  const Body body = body_of_participant({.mass_kg = 70.0, .height_m = 1.75});
  CHECK(body == make_body(make_segments({.mass_kg = 70.0, .height_m = 1.75})));
  CHECK(body_of_participant({.mass_kg = 187.0, .height_m = 1.8}).mass_kg > 180.0);
  for (const Participant& participant :
       {Participant{455.0, 1.8}, {251.0, 2.1}, {187.0, 1.55}, {30.0, 1.75}, {1.75, 70.0}, {70.0, 0.9}})
    CHECK_THROWS_AS(body_of_participant(participant), decid::Error);
}

TEST_CASE("mgh_text: small bodies have three digits") {
  CHECK(mgh_text(838.98) == "839");
  CHECK(mgh_text(99.97) == "100");
  CHECK(mgh_text(42.38) == "42.4");
  CHECK(mgh_text(0.21256) == "0.213");
}

TEST_CASE("refuse_person: a robot's body is not replaced, a person's and the default one are") {
  const Body person = body_of_participant({.mass_kg = 70.0, .height_m = 1.75});
  Protocol protocol = default_protocol();
  refuse_person(person, protocol, "here");
  protocol.experiment.body = body_of_participant({.mass_kg = 50.0, .height_m = 1.60});
  refuse_person(person, protocol, "here");
  protocol.experiment.body = {.mass_kg = 60.0, .com_height_m = 0.8, .inertia_kgm2 = 42.0};
  refuse_person({.mass_kg = 7.0, .com_height_m = 0.5, .inertia_kgm2 = 2.0}, protocol, "here");
  check_error([&] { refuse_person(person, protocol, "here"); }, decid::Code::setting_conflict, "here");
}
