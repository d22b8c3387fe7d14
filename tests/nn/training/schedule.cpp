// Tests of nn/training/schedule.hpp: rates against the formulas of its header, written out by hand.
// The cosine is compared with libm's: both err by a few units of the last place.
#include "nn/training/schedule.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "tests/helpers.hpp"

using decid::nn::Schedule;
using decid::test::check_error;

TEST_CASE("Schedule: cosine from the base rate to nearly 0 along half a period") {
  const Schedule schedule("cosine", 0.1, 1000, 10);
  CHECK(schedule.rate(0) == 0.1);
  CHECK(schedule.rate(500) == 0.05);
  for (long long step = 0; step < 1000; step += 7) {
    CAPTURE(step);
    const double expected = 0.05 * (1 + std::cos(std::numbers::pi * static_cast<double>(step) / 1000));
    CHECK(std::abs(schedule.rate(step) - expected) < 0.1 * 4 * std::numeric_limits<double>::epsilon());
    if (step > 0) CHECK(schedule.rate(step) < schedule.rate(step - 1));
  }
  CHECK(schedule.rate(999) > 0);
  CHECK(schedule.rate(999) < 0.1 * 2.5e-6);  // (pi / 2000)^2 = 2.467e-6
}

TEST_CASE("Schedule: step multiplies by the factor every EPOCHS epochs") {
  const Schedule schedule("step:3:0.5", 0.8, 1000, 10);
  CHECK(schedule.rate(0) == 0.8);
  CHECK(schedule.rate(29) == 0.8);
  CHECK(schedule.rate(30) == 0.4);
  CHECK(schedule.rate(59) == 0.4);
  CHECK(schedule.rate(60) == 0.2);
  CHECK(schedule.rate(95) == 0.1);
  CHECK(Schedule("step:1:1", 0.8, 1000, 1).rate(999) == 0.8);
  CHECK(Schedule("step:1:1e-1", 0.5, 10, 1).rate(1) == 0.05);
}

TEST_CASE("Schedule: warm-up rises linearly and meets the schedule") {
  const Schedule constant("constant", 0.4, 100, 10, 4);
  CHECK(constant.rate(0) == 0.1);
  CHECK(constant.rate(1) == 0.2);
  CHECK(constant.rate(3) == 0.4);
  CHECK(constant.rate(4) == 0.4);
  const Schedule cosine("cosine", 0.4, 100, 10, 4), cold("cosine", 0.4, 100, 10);
  CHECK(cosine.rate(1) == 0.2);
  for (const long long step : {4LL, 5LL, 50LL, 99LL}) CHECK(cosine.rate(step) == cold.rate(step));
  // From the warm-up's end a cosine begins at the base rate, and is that of the other steps.
  const Schedule continuous("cosine", 0.4, 100, 10, 40, Schedule::CosineFrom::warmup_end), rest("cosine", 0.4, 60, 10);
  for (const long long at : {0LL, 1LL, 30LL, 59LL}) CHECK(continuous.rate(40 + at) == rest.rate(at));
  CHECK(continuous.rate(39) == 0.4);
  CHECK(continuous.rate(40) == 0.4);
  CHECK(continuous.rate(1000) == rest.rate(59));
  CHECK(Schedule("cosine", 1, 2, 1, 1000, Schedule::CosineFrom::warmup_end).rate(1) == 2e-3);
  const Schedule step("step:1:0.5", 0.4, 100, 10, 15);
  CHECK(step.rate(14) == 0.4);
  CHECK(step.rate(15) == 0.2);  // the warm-up takes the first drop's place, and does not put off the second
  CHECK(step.rate(20) == 0.1);
  CHECK(Schedule("constant", 1, 2, 1, 1000).rate(1) == 2e-3);  // longer than the training
}

TEST_CASE("Schedule: beyond its end a rate stays that of the last step") {
  for (const char* text : {"constant", "cosine", "step:1:0.5"}) {
    CAPTURE(text);
    const Schedule schedule(text, 0.1, 100, 10);
    const double last = schedule.rate(99);
    for (const long long step : {100LL, 101LL, 150LL, 200LL, 1'000'000LL, std::numeric_limits<long long>::max()})
      CHECK(schedule.rate(step) == last);
    CHECK(schedule.rate(-1) == schedule.rate(0));
  }
  // A warm-up that is longer than the training does not go on behind it.
  const Schedule warming("constant", 1, 2, 1, 1000);
  CHECK(warming.rate(500) == warming.rate(1));
}

TEST_CASE("Schedule: texts and numbers that are refused") {
  const auto refused = [](const char* text, double rate = 0.1, long long steps = 10, long long epoch = 5,
                          long long warmup = 0) {
    CAPTURE(text);
    check_error([&] { Schedule(text, rate, steps, epoch, warmup); }, decid::Code::setting_malformed, text);
  };
  for (const char* text : {"",
                           "Constant",
                           "constant ",
                           "cosine:3",
                           "linear",
                           "step",
                           "step:",
                           "step:x:0.5",
                           "step::0.5",
                           "step:0:0.5",
                           "step:-1:0.5",
                           "step:3",
                           "step:3,0.5",
                           "step:1.5:0.5",
                           "step: 3:0.5",
                           "step:99999999999999999999:0.5",
                           "step:3:",
                           "step:3:x",
                           "step:3:0",
                           "step:3:-0.5",
                           "step:3:1.5",
                           "step:3:nan",
                           "step:3:inf",
                           "step:3:0.5x",
                           "step:3:0.5:2",
                           "step:3:1e-999"})
    refused(text);
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double rate : {0.0, -0.1, 1e6, infinity, -infinity, std::nan("")}) refused("constant", rate);
  for (const long long steps : {0LL, -5LL}) refused("constant", 0.1, steps);
  refused("constant", 0.1, 10, 0);
  refused("constant", 0.1, 10, 5, -1);
}
