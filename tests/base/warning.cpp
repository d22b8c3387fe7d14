// Tests which results warnings make unusable.
#include "base/warning.hpp"

#include <doctest/doctest.h>

using namespace decid;

TEST_CASE("trust: the most severe warning decides") {
  Warnings warnings;
  CHECK(worst_trust(warnings) == Trust::usable);
  add_info(warnings, "resampled", "from 50 Hz");
  CHECK(worst_trust(warnings) == Trust::usable);
  add_invalid(warnings, "out_of_distribution", "looks unlike all");
  add_caution(warnings, "small_sway", "is small");
  CHECK(worst_trust(warnings) == Trust::not_usable);
  warnings.erase(warnings.begin() + 1);
  CHECK(worst_trust(warnings) == Trust::caution);
  CHECK(warnings.front() == Warning{Severity::info, "resampled", "from 50 Hz"});
}
