// The journal of a fit: what is kept, what a kill leaves, and what does not belong together.
#include "tools/decid/commands/fit_journal.hpp"

#include "base/error.hpp"
#include "identify/result_archive.hpp"
#include "tests/tools/decid/run.hpp"

using decid::RecordingResult;
using decid::to_bytes;
using namespace decid::test;
using decid::tools::FitJournal;

namespace {

const std::string settings = "{\"version\": \"1\"}";

RecordingResult result_of(const std::string& file) {
  RecordingResult result;
  result.file = file;
  result.trial = decid::recording::make_trial({0.1F, -0.0F});
  result.trial.tilt = decid::recording::TiltMatch{.delay_s = 1.5, .moved_before = false};
  result.estimate.parameters = {1e-300, 2.0 / 3.0};
  result.explanation.frf.emplace().linear = {{0.5, -1.0}};
  result.warnings = {{decid::Severity::caution, "code", "\xC3\xA9\n"}};
  result.fit.emplace().answer = decid::FitFigures::Answer::network;
  result.fit->check.responses.gain.high = {0.3};
  return result;
}
const RecordingResult result = result_of("k");

std::string refusal(const std::string& path, const std::string& with) {
  return name(error_of([&] { const FitJournal journal(path, with, true); }).code());
}

}  // namespace

TEST_CASE("journal: entries are read back to the bit") {
  const Folder folder;
  const std::string path = folder / "o.journal";
  {
    FitJournal journal(path, settings, true);
    CHECK_FALSE(journal.find("k"));
    journal.append("k", result);
    journal.append("l", result_of("other"));
  }
  FitJournal again(path, settings, true);
  const std::optional<RecordingResult> found = again.find("k");
  REQUIRE(found);
  CHECK(to_bytes(*found) == to_bytes(result));
  CHECK(found->estimate.parameters == result.estimate.parameters);
  CHECK(found->trial.sway_rad() == result.trial.sway_rad());
  CHECK(found->trial.tilt->moved_before == false);
  CHECK(found->explanation.frf->linear == result.explanation.frf->linear);
  CHECK(found->warnings == result.warnings);
  CHECK(found->fit->answer == decid::FitFigures::Answer::network);
  CHECK(found->fit->check.responses.gain.high == std::vector{0.3});
  CHECK_FALSE(found->truth);
  CHECK(again.find("l")->file == "other");
  CHECK_FALSE(again.find(""));
  again.append("m", result);
  again.remove();
  CHECK_FALSE(std::filesystem::exists(path));
}

TEST_CASE("journal: without resume it begins empty, of other settings it is refused, and one process writes it") {
  const Folder folder;
  const std::string path = folder / "o.journal";
  {
    FitJournal journal(path, settings, false);
    journal.append("k", result);
    CHECK(refusal(path, settings) == "file_in_use");
  }
  CHECK(refusal(path, "{}") == "file_differs");
  CHECK_NOTHROW(FitJournal(path, settings, true));
  CHECK_FALSE(FitJournal(path, settings, false).find("k"));
  CHECK_FALSE(FitJournal(path, settings, true).find("k"));
}

TEST_CASE("journal: another file of its name is refused and stays as it is") {
  const Folder folder;
  const std::string path = folder / "o.journal";
  for (const char* content : {"my notes", "decid fit journal 2\n", "x"})
    for (const bool resume : {false, true}) {
      write_text(path, content);
      CHECK(error_of([&] { const FitJournal journal(path, settings, resume); }).code() ==
            decid::Code::file_unsupported);
      CHECK(read_text(path) == content);
    }
}

TEST_CASE("archive: bytes of another value are refused") {
  const std::string bytes = to_bytes(result);
  CHECK_THROWS_AS(decid::from_bytes<RecordingResult>(bytes.substr(0, bytes.size() - 1)), decid::Error);
  CHECK_THROWS_AS(decid::from_bytes<RecordingResult>(bytes + '0'), decid::Error);
  CHECK_THROWS_AS(decid::from_bytes<std::string>(std::string(8, '\xff')), decid::Error);
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

TEST_CASE("journal: the files beside a recording of BIDS, its rate and channels, are part of it") {
  const Folder folder;
  write_text(folder / "a_motion.tsv", "1");
  const std::string alone = FitJournal::key(folder / "a_motion.tsv");
  write_text(folder / "a_channels.tsv", "name\nx\n");
  write_text(folder / "a_motion.json", R"({"SamplingFrequency": 100})");
  const std::string with_both = FitJournal::key(folder / "a_motion.tsv");
  CHECK(alone != with_both);
  CHECK(with_both == FitJournal::key(folder / "a_motion.tsv"));
  write_text(folder / "a_motion.json", R"({"SamplingFrequency": 50})");
  CHECK(with_both != FitJournal::key(folder / "a_motion.tsv"));
}
