// Recordings of a plan: errors of their protocols, and notes on priors that bodies share.
#include "identify/study/study_results.hpp"

#include <cmath>

#include "base/text.hpp"
#include "sim/body_model.hpp"
#include "tests/helpers.hpp"
#include "tests/identify/study/sheet_files.hpp"
#include "tests/posterior/trial.hpp"

using namespace decid;
using namespace decid::test;

TEST_CASE("PlanFitter: priors of gains that bodies of several sizes share are noted, other priors are not") {
  const TemporaryFolder folder;
  const sim::Protocol protocol = sines_protocol();
  std::string text = "sway_deg\n";
  for (int k = 0; k < protocol.samples(); ++k) text += format("%.9f\n", std::sin(0.1 * k));
  const std::vector<RecordingSource> sources{write_text(folder / "a.csv", text), write_text(folder / "b.csv", text)};
  const std::string rate = format("%g", protocol.experiment.sample_rate_hz);
  const auto noted = [&](const std::string& weight_of_b, const posterior::ParameterPrior& prior) {
    const auto sheet = write_text(folder / "s.csv", "participant_id,file,weight,height,rate\nA,a.csv,70,175," + rate +
                                                        "\nB,b.csv," + weight_of_b + ",175," + rate + "\n");
    const RecordingPlan plan = make_plan(read_sheet(sheet), sources, Choice::by_sheet, {});
    FitRequest request;
    request.priors.parameters = {prior};
    const PlanFitter fitter(nullptr, protocol, plan, request);
    const std::vector<std::size_t> places{0, 1};
    std::size_t count = 0;
    for (const RecordingResult& one : fitter.read(places)) {
      REQUIRE_FALSE(one.error);
      count += has(one.warnings, "priors_of_all_bodies") ? 1 : 0;
    }
    return count;
  };
  const posterior::ParameterPrior stiffness{.name = "Kp", .range = posterior::ParameterPrior::Range{300.0, 1500.0}};
  CHECK(noted("90", stiffness) == 2);
  CHECK(noted("70", stiffness) == 0);
  CHECK(noted("90", {.name = "Kd", .fixed = 250.0}) == 2);
  CHECK(noted("90", {.name = "Kd", .fixed = 0.3, .over_mgh = {.fixed = true}}) == 0);
  CHECK(noted("90", {.name = "Kp",
                     .range = posterior::ParameterPrior::Range{300.0, 1500.0},
                     .normal = posterior::ParameterPrior::Normal{1.0, 0.2},
                     .over_mgh = {.normal = true}}) == 2);
  CHECK(noted("90", {.name = "delay", .normal = posterior::ParameterPrior::Normal{0.12, 0.02}}) == 0);
}

TEST_CASE("PlanFitter, PlanIdentifier: an error of a sheet's protocol names the sheet and the line of each recording") {
  const TemporaryFolder folder;
  const std::string sheet = "participant_id\tfile\tprotocol\nA\ta.csv\tnone.json\nB\tb.csv\t\nC\tc.csv\tnone.json\n";
  const RecordingPlan plan = plan_of_text(folder, sheet, {"a.csv", "b.csv", "c.csv"}, Choice::by_sheet);
  const std::vector<std::size_t> places{0, 2};
  const std::vector<RecordingResult> fitted = PlanFitter(nullptr, sines_protocol(), plan, {}).read(places);
  check_has(fitted[0].error, Code::file_missing, "participants.tsv, line 2: none.json");
  check_has(fitted[1].error, Code::file_missing, "participants.tsv, line 4: none.json");
  const Model model = model_or_built_in("");
  const std::vector<RecordingResult> identified = PlanIdentifier(model, "built-in", plan, 1).identify(places);
  check_has(identified[1].error, Code::file_missing, "participants.tsv, line 4: none.json");
}

TEST_CASE("PlanFitter: a parameter that is fixed by convention is not compared, also if the sheet's first line fails") {
  const TemporaryFolder folder;
  const std::string sheet = "participant_id\tfile\tprotocol\nA\ta.csv\tnone.json\nB\tb.csv\t\n";
  const RecordingPlan plan = plan_of_text(folder, sheet, {"a.csv", "b.csv"}, Choice::by_sheet);
  sim::Protocol protocol = sines_protocol();
  protocol.experiment.body_model = &sim::dec2015();
  CHECK(PlanFitter(nullptr, protocol, plan, {}).report().fixed_parameters() == std::vector<std::string>{"Kp"});
}
