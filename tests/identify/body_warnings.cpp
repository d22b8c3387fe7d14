// Bodies that few people have, and the recordings that they warn of.
#include "identify/body_warnings.hpp"

#include <cmath>

#include "base/text.hpp"
#include "identify/study/recording_plan.hpp"
#include "sim/segments.hpp"
#include "tests/helpers.hpp"
#include "tests/sim/tiny_protocol.hpp"

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

TEST_CASE("bring: the body of a recording is checked, whether a call or a sheet gives it") {
  const sim::Protocol protocol = tiny_protocol();
  const recording::ProtocolPlan plan(protocol);
  const sim::Body rare = sim::body_of_participant({.mass_kg = 154.0, .height_m = 1.75}),
                  usual = sim::body_of_participant({.mass_kg = 70.0, .height_m = 1.75});
  std::vector<double> sway_rad;
  std::string text = "sway_deg\n";
  for (int k = 0; k < protocol.samples(); ++k) {
    sway_rad.push_back(sim::rad_per_deg * std::sin(0.1 * k));
    text += format("%.9f\n", std::sin(0.1 * k));
  }
  const auto of_samples = [&](const std::optional<sim::Body>& body) {
    return bring(recording::make_recording(sway_rad, 100.0), plan, {}, body).warnings;
  };
  CHECK(has(of_samples(rare), "implausible_body"));
  CHECK_FALSE(has(of_samples(usual), "implausible_body"));
  CHECK_FALSE(has(of_samples({}), "implausible_body"));

  const TemporaryFolder folder;
  const std::filesystem::path a = write_text(folder / "a.csv", text), b = write_text(folder / "b.csv", text);
  const auto warnings_of = [&](const PlannedRecording& planned) {
    REQUIRE_FALSE(planned.error);
    const RecordingResult result = read_source(plan, planned.source, planned.reading);
    REQUIRE_FALSE(result.error);
    return result.warnings;
  };
  const auto sheet =
      write_text(folder / "s.csv", "participant_id,file,weight,height,rate\nA,a.csv,154,175,100\nB,b.csv,70,175,100\n");
  const RecordingPlan by_sheet = make_plan(read_sheet(sheet), {a, b}, Choice::by_sheet, {});
  REQUIRE(by_sheet.recordings.size() == 2);
  CHECK(has(warnings_of(by_sheet.recordings[0]), "implausible_body"));
  CHECK_FALSE(has(warnings_of(by_sheet.recordings[1]), "implausible_body"));
  ReadOptions reading;
  reading.recording.rate_hz = 100.0;
  reading.body = rare;
  CHECK(has(warnings_of(make_plan({a}, reading).recordings[0]), "implausible_body"));
}
