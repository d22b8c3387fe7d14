// Tests of base/archive.hpp: values come back as they were, and bytes that are cut off, too long or absurd are refused.
#include "base/archive.hpp"

#include <doctest/doctest.h>

#include <vector>

using namespace decid;

namespace {

struct Inner {
  double value = 0.0;
  bool flag = false;
  bool operator==(const Inner&) const = default;

  template <class Archive>
  void archive(Archive& a) {
    a(value, flag);
  }
};

struct Outer {
  std::string name;
  std::vector<Inner> list;
  std::vector<float> numbers;
  std::optional<Inner> maybe;
  std::optional<Error> error;

  template <class Archive>
  void archive(Archive& a) {
    a(name, list, numbers, maybe, error);
  }
};

Outer some() {
  return {std::string("a\0b", 3),
          {{1.5, true}, {-0.0, false}},
          {1.0F, 2.5F},
          Inner{3.0, true},
          Error(Code::file_empty, "w", "p", "r")};
}

}  // namespace

TEST_CASE("archive: values come back as they were") {
  const Outer read = from_bytes<Outer>(to_bytes(some()));
  CHECK(read.name == some().name);
  CHECK(read.list == some().list);
  CHECK(read.numbers == some().numbers);
  CHECK(read.maybe == some().maybe);
  REQUIRE(read.error.has_value());
  CHECK(read.error->code() == Code::file_empty);
  CHECK(read.error->where() == "w");
  CHECK(read.error->problem() == "p");
  CHECK(read.error->remedy() == "r");
  const Outer empty = from_bytes<Outer>(to_bytes(Outer{}));
  CHECK(empty.list.empty());
  CHECK_FALSE(empty.maybe.has_value());
  CHECK_FALSE(empty.error.has_value());
}

TEST_CASE("archive: bytes that are cut off anywhere, too long, or of an absurd length are refused") {
  const std::string bytes = to_bytes(some());
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    CAPTURE(length);
    CHECK_THROWS_AS(from_bytes<Outer>(std::string_view(bytes).substr(0, length)), Error);
  }
  CHECK_THROWS_AS(from_bytes<Outer>(bytes + "x"), Error);
  CHECK_THROWS_AS(from_bytes<std::string>(std::string(8, '\xff')), Error);
}
