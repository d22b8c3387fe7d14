// The journal of a fit: what is kept, what a kill leaves, and what does not belong together.
#include "tools/decid/fit_journal.hpp"

#include <doctest/doctest.h>

#include <memory>

#include "base/error.hpp"
#include "base/files/json_object.hpp"
#include "tests/tools/decid/run.hpp"

using decid::Json;
using decid::test::Folder;
using decid::test::read_text;
using decid::test::write_text;
using decid::tools::FitJournal;

namespace {

const Json settings{{"version", "1"}, {"options", {"--seed 3"}}};
const Json result{{"text", "\xC3\xA9\n"}, {"draws", {0.1, 1e-300, 2.0 / 3.0}}};

std::string refusal(const std::string& path, const Json& with) {
  try {
    const FitJournal journal(path, with, true);
  } catch (const decid::Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("journal: what was written is there again, to the bit") {
  const Folder folder;
  const std::string path = folder / "o.journal";
  {
    FitJournal journal(path, settings, true);
    CHECK(journal.find("k") == nullptr);
    journal.append("k", result);
    journal.append("l", Json{{"text", "other"}});
  }
  FitJournal again(path, settings, true);
  REQUIRE(again.find("k") != nullptr);
  CHECK(*again.find("k") == result);
  CHECK(again.find("l")->at("text") == "other");
  CHECK(again.find("") == nullptr);
  again.append("m", result);
  again.remove();
  CHECK_FALSE(std::filesystem::exists(path));
}

TEST_CASE("journal: wherever it was cut off, whole lines stay and others are written behind them") {
  const Folder folder;
  const std::string path = folder / "o.journal";
  std::size_t first = 0;
  {
    FitJournal journal(path, settings, false);
    journal.append("k", result);
    first = read_text(path).size();
    journal.append("l", result);
  }
  const std::string whole = read_text(path);
  for (std::size_t cut = 0; cut < whole.size(); ++cut) {
    write_text(path, whole.substr(0, cut));
    FitJournal journal(path, settings, true);
    CAPTURE(cut);
    REQUIRE((journal.find("k") != nullptr) == (cut >= first));
    REQUIRE(journal.find("l") == nullptr);
    if (journal.find("k") == nullptr) journal.append("k", result);
    journal.append("l", result);
    REQUIRE(read_text(path) == whole);
  }
  // A power failure may leave zeros.
  write_text(path, whole.substr(0, first) + std::string(40, '\0') + "\n" + whole.substr(first));
  CHECK(FitJournal(path, settings, true).find("l") == nullptr);
  write_text(path, whole.substr(0, first) + "{}\n" + whole.substr(first));
  CHECK(FitJournal(path, settings, true).find("l") == nullptr);
}

TEST_CASE("journal: without resume it begins empty, of other settings it is refused, and one process writes it") {
  const Folder folder;
  const std::string path = folder / "o.journal";
  {
    FitJournal journal(path, settings, false);
    journal.append("k", result);
    CHECK(refusal(path, settings).find("is being written by another process") != std::string::npos);
  }
  CHECK(refusal(path, {{"version", "2"}}).find("o.journal: is of other settings") != std::string::npos);
  CHECK(refusal(path, settings).empty());
  CHECK(FitJournal(path, settings, false).find("k") == nullptr);
  CHECK(FitJournal(path, settings, true).find("k") == nullptr);
}

TEST_CASE("journal: a recording is its name and its content") {
  const Folder folder;
  write_text(folder / "a", "1");
  write_text(folder / "b", "1");
  const std::string key = FitJournal::key(folder / "a");
  CHECK(key.size() == 64);
  CHECK(key == FitJournal::key(folder / "a"));
  CHECK(key != FitJournal::key(folder / "b"));
  CHECK(key != FitJournal::key({folder / "a", "1"}));
  CHECK(FitJournal::key({folder / "a", "1"}) != FitJournal::key({folder / "a", "2"}));
  write_text(folder / "a", "2");
  CHECK(key != FitJournal::key(folder / "a"));
  CHECK(FitJournal::key(folder / "none").empty());
}
