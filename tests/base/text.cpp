// Text for people.
#include "base/text.hpp"

#include <doctest/doctest.h>

using namespace decid;

TEST_CASE("counted: the plural of all but one") {
  CHECK(counted(0, "trial") == "0 trials");
  CHECK(counted(1, "trial") == "1 trial");
  CHECK(counted(12100, "sample") == "12100 samples");
}

TEST_CASE("duration_text: rounded up") {
  CHECK(duration_text(41.2) == "42 s");
  CHECK(duration_text(200) == "3 min 20 s");
  CHECK(duration_text(4320) == "1 h 12 min");
}

TEST_CASE("one_line: control characters are question marks") {
  CHECK(one_line("a\nb\x1b[31m") == "a?b?[31m");
}
