// Numbers from whole texts.
#include "base/number.hpp"

#include <doctest/doctest.h>

TEST_CASE("number_from: a number is the whole text") {
  CHECK(decid::number_from<int>("12") == 12);
  CHECK(decid::number_from<int>("-3") == -3);
  CHECK(decid::number_from<double>("1.5e3") == 1500.0);
  for (const char* text : {"", " 1", "1 ", "1x", "x", "+1", "1.5", "99999999999"})
    CHECK_FALSE(decid::number_from<int>(text).has_value());
  CHECK_FALSE(decid::number_from<std::size_t>("-1").has_value());
  CHECK_FALSE(decid::number_from<double>("1e999").has_value());
  CHECK_FALSE(decid::number_from<double>("1,5").has_value());
}
