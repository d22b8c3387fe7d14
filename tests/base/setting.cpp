// Settings in messages: their names, or a program's own.
#include "base/setting.hpp"

#include <doctest/doctest.h>

TEST_CASE("a setting has its name until a program has another one for it") {
  CHECK(decid::setting("fill_gaps") == "fill_gaps");
  decid::name_settings([](std::string_view name) { return "<" + std::string(name) + ">"; });
  CHECK(decid::setting("fill_gaps") == "<fill_gaps>");
  decid::name_settings(nullptr);
  CHECK(decid::setting("fill_gaps") == "fill_gaps");
}
