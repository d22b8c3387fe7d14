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

TEST_CASE("PlanFitter: a person's body does not replace a robot's, of the sheet's protocol or the call's") {
  const TemporaryFolder folder;
  write_text(folder / "robot.json", R"({"body": {"mass_kg": 60, "com_height_m": 0.8, "inertia_kgm2": 42}})");
  const std::string robot = (folder / "robot.json").string();
  const std::string sheet = "participant_id\tfile\tweight\theight\tprotocol\nA\ta.csv\t70\t1.75\t" + robot +
                            "\nB\tb.csv\t70\t1.75\t\nC\tc.csv\t\t\t" + robot + "\n";
  const RecordingPlan plan = plan_of_text(folder, sheet, {"a.csv", "b.csv", "c.csv"}, Choice::by_sheet);
  const std::vector<std::size_t> places{0, 1, 2};
  const auto conflicts = [&](const sim::Protocol& of_call) {
    std::vector<bool> found;
    for (const RecordingResult& one : PlanFitter(nullptr, of_call, plan, {}).read(places))
      found.push_back(one.error && one.error->code() == Code::setting_conflict);
    return found;
  };
  CHECK(conflicts(sim::default_protocol()) == std::vector<bool>{true, false, false});
  sim::Protocol of_robot = sim::default_protocol();
  of_robot.experiment.body = {.mass_kg = 60.0, .com_height_m = 0.8, .inertia_kgm2 = 42.0};
  CHECK(conflicts(of_robot) == std::vector<bool>{true, true, false});
  // Without a person's body, the protocol's own is fitted: the line's, or the call's.
  const std::string protocols = "participant_id\tfile\tprotocol\nA\ta.csv\t" + robot + "\nB\tb.csv\t\n";
  sim::Protocol of_other = sim::default_protocol();
  of_other.experiment.body = {.mass_kg = 7.0, .com_height_m = 0.5, .inertia_kgm2 = 2.0};
  ReadOptions reading;
  reading.body = of_other.experiment.body;
  const std::vector<RecordingSource> sources{{folder / "a.csv"}, {folder / "b.csv"}};
  const RecordingPlan of_protocols =
      make_plan(read_sheet(write_text(folder / "t.tsv", protocols)), sources, Choice::by_sheet, reading);
  const Report report = PlanFitter(nullptr, of_other, of_protocols, {}).report();
  CHECK(report.protocol.experiment.body == of_robot.experiment.body);
  REQUIRE(report.other_settings.size() == 1);
  CHECK(report.other_settings[0].protocol.experiment.body == of_other.experiment.body);
}

TEST_CASE("PlanFitter: a person's body of the call, and a robot's of a line: the remedy is a call of their own") {
  const TemporaryFolder folder;
  write_text(folder / "robot.json", R"({"body": {"mass_kg": 60, "com_height_m": 0.8, "inertia_kgm2": 42}})");
  const std::string sheet = "participant_id\tfile\tprotocol\nA\ta.csv\trobot.json\nB\tb.csv\t\n";
  ReadOptions reading;  // as of --mass and --height, or of a protocol with a person's body
  reading.body = sim::body_of_participant({.mass_kg = 60.0, .height_m = 1.65});
  const std::vector<RecordingSource> sources{{folder / "a.csv"}, {folder / "b.csv"}};
  const RecordingPlan plan =
      make_plan(read_sheet(write_text(folder / "s.tsv", sheet)), sources, Choice::by_sheet, reading);
  const std::vector<std::size_t> places{0};
  const std::optional<Error> error = PlanFitter(nullptr, sim::default_protocol(), plan, {}).read(places)[0].error;
  check_has(error, Code::setting_conflict, "s.tsv, line 2: protocol robot");
  CHECK(contains(error->remedy(), "call of their own"));
}

TEST_CASE("PlanIdentifier: the body of a line's protocol: a person's counts, a robot's is not the network's") {
  const TemporaryFolder folder;
  write_text(folder / "robot.json", R"({"body": {"mass_kg": 60, "com_height_m": 0.8, "inertia_kgm2": 42}})");
  write_text(folder / "person.json", R"({"body": {"participant": {"mass_kg": 60, "height_m": 1.65}}})");
  const std::string sheet =
      "participant_id\tfile\tweight\theight\tprotocol\nA\ta.csv\t\t\trobot.json\nB\tb.csv\t\t\tperson.json\n"
      "C\tc.csv\t70\t1.75\tperson.json\nD\td.csv\t70\t1.75\trobot.json\nE\te.csv\t\t\tdefault\n";
  const RecordingPlan plan =
      plan_of_text(folder, sheet, {"a.csv", "b.csv", "c.csv", "d.csv", "e.csv"}, Choice::by_sheet);
  const Model model = model_or_built_in("");
  std::vector<std::string> files;
  PlanIdentifier identifier(model, "built-in", plan, 1, &files);
  CHECK(std::ranges::count(files, (folder / "person.json").string()) == 2);
  const std::vector<std::size_t> robots{0, 3};
  const std::vector<RecordingResult> refused = identifier.identify(robots);
  check_has(refused[0].error, Code::protocol_mismatch, "participants.tsv, line 2: protocol ");
  check_has(refused[1].error, Code::protocol_mismatch, "participants.tsv, line 5: protocol ");
  CHECK(contains(refused[0].error->remedy(), "decid fit"));
  const Report report = identifier.report();
  REQUIRE(report.other_settings.size() == 4);
  const auto body_of = [&](std::size_t k) { return report.other_settings[k - 1].protocol.experiment.body; };
  CHECK(body_of(1) == sim::body_of_participant({.mass_kg = 60.0, .height_m = 1.65}));
  CHECK_FALSE(report.other_settings[0].body_assumed);
  CHECK(body_of(2) == sim::body_of_participant({.mass_kg = 70.0, .height_m = 1.75}));
  CHECK(report.other_settings[3].body_assumed);
}

TEST_CASE("PlanFitter: a parameter that is fixed by convention is not compared, also if the sheet's first line fails") {
  const TemporaryFolder folder;
  const std::string sheet = "participant_id\tfile\tprotocol\nA\ta.csv\tnone.json\nB\tb.csv\t\n";
  const RecordingPlan plan = plan_of_text(folder, sheet, {"a.csv", "b.csv"}, Choice::by_sheet);
  sim::Protocol protocol = sines_protocol();
  protocol.experiment.body_model = &sim::dec2015();
  CHECK(PlanFitter(nullptr, protocol, plan, {}).report().fixed_parameters() == std::vector<std::string>{"Kp"});
}
