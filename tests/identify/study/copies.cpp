// Copies among the recordings of a plan, and recordings that are given twice.
#include <doctest/doctest.h>

#include "identify/study/recording_plan.hpp"
#include "identify/study/study_results.hpp"
#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::test;

namespace {

std::vector<std::string> codes(const PlannedRecording& planned) {
  std::vector<std::string> all;
  for (const Warning& warning : planned.warnings) all.push_back(warning.code);
  return all;
}

}  // namespace

TEST_CASE("plan: copies of a recording have a caution that names the other file") {
  const TemporaryFolder folder;
  for (const char* name : {"a.csv", "copy.csv"}) write_text(folder / name, "1\n2\n");
  write_text(folder / "b.csv", "1\n3\n");  // of the same size
  const RecordingPlan plan =
      make_plan({folder / "a.csv", folder / "b.csv", folder / "copy.csv", folder / "none.csv"}, {});
  CHECK(codes(plan.recordings[0]) == std::vector<std::string>{"same_content"});
  CHECK(codes(plan.recordings[1]).empty());
  CHECK(codes(plan.recordings[2]) == std::vector<std::string>{"same_content"});
  CHECK(codes(plan.recordings[3]).empty());
  CHECK(plan.recordings[0].warnings[0].severity == Severity::caution);
  CHECK(contains(plan.recordings[0].warnings[0].text, "copy.csv"));
  CHECK(contains(plan.recordings[2].warnings[0].text, "a.csv"));
  RecordingResult result;
  set_planned(result, plan.recordings[0]);
  CHECK(result.trust() == Trust::caution);

  const RecordingPlan twice = make_plan({folder / "a.csv", folder / "a.csv"}, {});
  CHECK(codes(twice.recordings[1]).size() == 1);
  // Trials of one file differ.
  const RecordingPlan trials =
      make_plan({RecordingSource(folder / "a.csv", "1"), RecordingSource(folder / "a.csv", "2")}, {});
  CHECK(codes(trials.recordings[0]).empty());
}

TEST_CASE("plan: columns of one file, by a sheet, are not copies") {
  const TemporaryFolder folder;
  write_text(folder / "a.csv", "left,right\n1,2\n");
  const auto sheet = write_text(folder / "s.csv", "participant_id,file,column\nA,a.csv,left\nB,a.csv,right\n");
  const RecordingPlan plan = make_plan(read_sheet(sheet), {folder / "a.csv"}, Choice::by_sheet, {});
  REQUIRE(plan.recordings.size() == 2);
  CHECK(codes(plan.recordings[0]).empty());
  write_text(folder / "b.csv", "left,right\n1,2\n");
  const auto copies = write_text(folder / "s.csv", "participant_id,file,column\nA,a.csv,left\nB,b.csv,left\n");
  const RecordingPlan copied =
      make_plan(read_sheet(copies), {folder / "a.csv", folder / "b.csv"}, Choice::by_sheet, {});
  CHECK(codes(copied.recordings[0]) == std::vector<std::string>{"same_content"});
  CHECK(codes(copied.recordings[1]) == std::vector<std::string>{"same_content"});
}

TEST_CASE("refuse_repeated: a recording that is given twice, also through a link") {
  const TemporaryFolder folder;
  write_text(folder / "a.csv", "1\n");
  write_text(folder / "b.csv", "1\n");
  std::filesystem::create_symlink(folder / "a.csv", folder / "link.csv");
  refuse_repeated(make_plan({folder / "a.csv", folder / "b.csv"}, {}), "--joint");
  for (const char* other : {"a.csv", "./a.csv", "link.csv"})
    check_error(
        [&] {
          refuse_repeated(make_plan({folder / "a.csv", folder / other}, {}), "--joint");
        },
        Code::setting_conflict, other);
}

TEST_CASE("warn_of_same_sway: two recordings with the same samples have a caution, once") {
  const auto result = [](const char* file, std::vector<float> sway) {
    RecordingResult made;
    made.file = file;
    made.trial = recording::make_trial(std::move(sway));
    return made;
  };
  std::vector<RecordingResult> all{result("a.csv", {1.0F, 2.0F}), result("b.csv", {1.0F, 2.5F}),
                                   result("a.xlsx", {1.0F, 2.0F}), result("c.csv", {1.0F, 2.0F})};
  add_caution(all[3].warnings, "same_content", "holds the same bytes as a.csv");
  all.push_back(result("none.csv", {}));
  all.back().error = Error(Code::file_missing, "none.csv", "is missing", "copy it");
  warn_of_same_sway(all);
  std::vector<std::size_t> counts;
  for (const RecordingResult& one : all) counts.push_back(one.warnings.size());
  CHECK(counts == std::vector<std::size_t>{1, 0, 1, 1, 0});
  CHECK(all[0].trust() == Trust::caution);
  CHECK(contains(all[0].warnings[0].text, "a.xlsx"));
  CHECK(contains(all[2].warnings[0].text, "a.csv"));
  CHECK(contains(all[3].warnings[0].text, "bytes"));
}
