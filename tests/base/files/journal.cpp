// The journal: entries come back, and damaged ones count as not written.
#include "base/files/journal.hpp"

#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::test;

TEST_CASE("Journal: entries are read back, dropped and written again") {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder / "work.journal";
  {
    Journal journal(path, "test 1");
    CHECK_FALSE(journal.request());
    journal.start("request");
    journal.append("one");
    journal.append("");
    journal.append("three");
    journal.sync();
  }
  const std::string whole = read_text(path);
  Journal journal(path, "test 1");
  CHECK(journal.path() == path);
  CHECK(journal.request() == "request");
  CHECK(journal.next() == "one");
  CHECK(journal.next() == "");
  CHECK(journal.next() == "three");
  CHECK_FALSE(journal.next());
  journal.back(5);
  CHECK(journal.next() == "three");
  journal.back(5);
  journal.append("3");  // drops what was behind
  CHECK_FALSE(journal.next());
  CHECK(read_text(path) == whole.substr(0, whole.size() - 4 - 73) + read_text(path).substr(whole.size() - 77));

  CHECK_FALSE(Journal(path, "test 2").request());
}

TEST_CASE("Journal: a truncated or damaged entry counts as not written, with all after it") {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder / "work.journal";
  {
    Journal journal(path, "test 1");
    journal.start("request");
    journal.append("one");
    journal.append("two");
  }
  const std::string whole = read_text(path);
  const std::size_t request = 7, request_end = request + 72 + 7, first_end = request_end + 72 + 3;
  REQUIRE(whole.size() == first_end + 72 + 3);
  for (std::size_t cut = 0; cut < whole.size(); ++cut) {
    CAPTURE(cut);
    write_text(path, whole.substr(0, cut));
    Journal journal(path, "test 1");
    REQUIRE(journal.request().has_value() == (cut >= request_end));
    if (cut < request_end) continue;
    REQUIRE(journal.next().has_value() == (cut >= first_end));
    REQUIRE_FALSE((cut >= first_end && journal.next().has_value()));
  }
  for (std::size_t place = request_end; place < whole.size(); place += 5) {
    CAPTURE(place);
    std::string damaged = whole;
    damaged[place] = static_cast<char>(damaged[place] ^ 0x10);
    write_text(path, damaged);
    Journal journal(path, "test 1");
    REQUIRE(journal.request());
    int sound = 0;
    while (journal.next()) ++sound;
    REQUIRE(sound == (place < first_end ? 0 : 1));
  }
}

TEST_CASE("Journal: one process at a time") {
  const TemporaryFolder folder;
  Journal journal(folder / "work.journal", "test 1"), other(folder / "work.journal", "test 1");
  CHECK(journal.try_lock());
  CHECK_FALSE(other.try_lock());
}
