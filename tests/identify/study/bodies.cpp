// Bodies that few people have.
#include <doctest/doctest.h>

#include "identify/study/recording_plan.hpp"
#include "sim/segments.hpp"
#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::test;

TEST_CASE("body_warnings: a body mass index that few people have is a caution") {
  const auto warnings = [](double mass_kg, double height_m) {
    return body_warnings(sim::body_of_participant({.mass_kg = mass_kg, .height_m = height_m}));
  };
  CHECK(warnings(70.0, 1.75).empty());
  CHECK(warnings(130.0, 1.75).empty());
  CHECK(warnings(17.0, 1.10).empty());  // a child
  CHECK(body_warnings({}).empty());
  for (const double mass_kg : {154.0, 37.5}) {  // pounds; an index below 13
    const Warnings found = warnings(mass_kg, 1.75);
    REQUIRE(found.size() == 1);
    CHECK(found[0].code == "implausible_body");
    CHECK(found[0].severity == Severity::caution);
  }
}

TEST_CASE("plan: only the recordings of an implausible body have its caution") {
  const TemporaryFolder folder;
  write_text(folder / "a.csv", "1\n");
  write_text(folder / "b.csv", "2\n");
  const auto sheet =
      write_text(folder / "s.csv", "participant_id,file,weight,height\nA,a.csv,154,175\nB,b.csv,70,175\n");
  const RecordingPlan plan = make_plan(read_sheet(sheet), {folder / "a.csv", folder / "b.csv"}, Choice::by_sheet, {});
  REQUIRE(plan.recordings[0].warnings.size() == 1);
  CHECK(plan.recordings[0].warnings[0].code == "implausible_body");
  CHECK(plan.recordings[1].warnings.empty());
  ReadOptions reading;
  reading.body = sim::body_of_participant({.mass_kg = 154.0, .height_m = 1.75});
  CHECK(make_plan({folder / "a.csv"}, reading).recordings[0].warnings.size() == 1);
}
