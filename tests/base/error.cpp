// Codes of errors: of a file that cannot be opened, and of a failed write.
#include "base/error.hpp"

#include <cerrno>

#include "tests/helpers.hpp"

using namespace decid;

TEST_CASE("a file that cannot be opened is missing or unreadable") {
  CHECK(opening_failed(ENOENT) == Code::file_missing);
  CHECK(opening_failed(ENOTDIR) == Code::file_missing);
  CHECK(opening_failed(EACCES) == Code::file_unreadable);
}

TEST_CASE("a failed write has its code, and the message's three parts") {
  const WriteError error("a.csv", "is full", "free space");
  CHECK(error.code() == Code::file_unwritable);
  CHECK(std::string(error.what()) == "a.csv: is full; free space");
}
