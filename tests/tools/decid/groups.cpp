// Groups of recordings: the table that names them, and what is reported of them.

#include <limits>
#include <tuple>

#include "base/error.hpp"
#include "base/files/json_object.hpp"
#include "sim/body_model.hpp"
#include "tests/tools/decid/run.hpp"
#include "tools/decid/group_file.hpp"
#include "tools/decid/results/group_results.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/report/json/group_verdicts.hpp"
#include "tools/report/json/groups_json.hpp"

using decid::Code;
using decid::GroupTable;
using decid::Json;
using decid::RecordingResult;
using decid::Report;
using decid::Severity;
using namespace decid::test;
using decid::tools::groups_text;
using decid::tools::read_group_table;
using decid::tools::report_text;
using decid::tools::verdicts_text;
using Names = std::vector<std::string>;

namespace {

GroupTable read(const std::string& table, const Names& recordings) {
  const Folder folder;
  std::filesystem::create_directory(folder / "in");
  write_text(folder / "in/g.csv", table);
  return read_group_table(folder / "in/g.csv", {recordings.begin(), recordings.end()});
}

Names members(const GroupTable& table, std::string decid::GroupMember::*text) {
  Names all;
  for (const decid::GroupMember& member : table.members) all.push_back(member.*text);
  return all;
}

void refused(const std::string& table, const Names& recordings, Code code, const char* fact) {
  CAPTURE(table);
  decid::test::check_error([&] { read(table, recordings); }, code, fact);
}

}  // namespace

TEST_CASE("read_group_table: its lines are of the recordings of which they are in a study's sheet") {
  // Letter case, accents and endings do not count; the best name does, and a person without a file is found by folders.
  const GroupTable table = read(
      "Gruppe;Age;File;Patient ID;weight\r\nold;70;A.CSV;S1;heavy\r\nOLD;;in/Ju\u0308rgen.mat;s1;80\r\n"
      "\"young, fit\";30;in/t.csv;S2;\r\n#N/A;;t.csv;;\r\nyoung, Fit;;;P4;\r\n;;d.csv;;\r\nold;;;P5;\r\n",
      {"in/a.csv", "in/J\u00FCrgen.csv", "in/t.csv", "u/t.csv", "P4/x.csv"});
  using decid::GroupMember;
  CHECK(members(table, &GroupMember::group) == Names{"old", "old", "young, fit", "", "young, fit"});
  CHECK(members(table, &GroupMember::participant) == Names{"S1", "S1", "S2", "", "P4"});
  CHECK(table.participant_column == "Patient ID");
  CHECK(table.unused == std::vector<decid::UnusedLine>{{7, "d.csv"}, {8, "P5"}});
}

TEST_CASE("read_group_table: without a column of people each recording is a person; equal lines count once") {
  const GroupTable table = read("file,group\na.csv,Old\na.csv,old\nlong.csv#2,x\n", {"a.csv", "in/long.csv#2"});
  CHECK(members(table, &decid::GroupMember::group) == Names{"Old", "x"});
  CHECK(members(table, &decid::GroupMember::participant) == Names{"a.csv", "in/long.csv#2"});
  CHECK(table.participant_column.empty());
}

TEST_CASE("read_group_table: what cannot be read is refused") {
  const Names recordings{"a.csv", "b.csv"};
  for (const char* empty : {"", "sep=;", "sep=;\n", "\n", "name,group\na.csv,x\n"})
    refused(empty, recordings, Code::column_missing, "g.csv, line 1");
  refused("file,name\na.csv,x\nb.csv,y\n", recordings, Code::column_missing, "\"group\"");
  refused("file,subject,group,participant\na.csv,1,x,1\n", recordings, Code::column_ambiguous, "line 1");
  refused("file,group\n,x\n", recordings, Code::value_missing, "line 2");
  refused("file,group,subject\na.csv,x,1\nb.csv,y,n/a\n", recordings, Code::value_missing, "line 3: has no subject");
  refused("file,group\na.csv,x\n.csv,x\n", recordings, Code::value_missing, "b.csv");
  refused("file,group\na.csv,x\na.csv,y\nb.csv,y\n", recordings, Code::value_invalid, "line 3");
  refused("file,group,subject\na.csv,x,1\nb.csv,y,2\na.csv,x,3\n", recordings, Code::value_invalid, "line 4");
  refused("file,group\na.csv,x\nb.csv,x\n", recordings, Code::setting_out_of_range, "1 group");
  refused("file,group\na.csv,\nb.csv,\n", recordings, Code::setting_out_of_range, "0 groups");
  // Faults of lines, but not of cells that do not count.
  refused("file,group\na.csv,x\nb.csv\n", recordings, Code::value_missing, "line 3");
  refused("file,weight,group\na.csv,70,5,x\nb.csv,70,y\n", recordings, Code::value_invalid, "line 2");
  refused("file,weight,group\na.csv,much,5,x\nb.csv,70,y\n", recordings, Code::value_invalid, "line 2: has 4 cells");
  CHECK(read("group,file,weight,unit\nx,a.csv,much,far\ny,b.csv\n", recordings).members.size() == 2);
}

namespace {

/// Reads a table of two groups, of `participants` each, that share the first `both`.
GroupTable read_shared(int participants, int both) {
  std::string table = "file,group,subject\n";
  Names recordings;
  for (const char* group : {"controls", "patients"})
    for (int i = 0; i < participants; ++i) {
      recordings.push_back(group + std::to_string(i) + ".csv");
      table += recordings.back() + "," + group + "," + (i < both ? "s" : group) + std::to_string(i) + "\n";
    }
  return read(table, recordings);
}

}  // namespace

TEST_CASE("two groups that share fewer than half of their people are refused") {
  const auto shared = [](int participants, int both, const char* fact) {
    decid::test::check_error([&] { read_shared(participants, both); }, Code::value_invalid, fact);
  };
  shared(20, 1, "g.csv: has s0 in both \"controls\" and \"patients\", but 38 of 39 people");
  shared(20, 9, "but 22 of 31 people");
  shared(3, 1, "but 4 of 5 people");
  for (const auto& [participants, both] : {std::pair(20, 0), {20, 10}, {1, 1}}) read_shared(participants, both);
  // The smaller group counts: a follow-up of two people out of four.
  read("file,group,subject\na,x,1\nb,x,2\nc,x,3\nd,x,4\ne,y,1\nf,y,2\n", {"a", "b", "c", "d", "e", "f"});
}

namespace {

const decid::sim::ParameterTable& parameters() {
  return decid::sim::single_pendulum().parameters;
}

/// A recording all of whose parameters are `value`.
RecordingResult recording(const std::string& file, double value, Severity severity = Severity::info) {
  RecordingResult made;
  made.file = file;
  made.trial = decid::recording::make_trial({0.0F, 0.01F});
  made.estimate.parameters = decid::sim::Parameters(parameters().size());
  for (double& of_parameter : made.estimate.parameters) of_parameter = value;
  made.warnings = {{severity, "spikes", "some"}};
  return made;
}

RecordingResult of_other_tilt(const std::string& file) {
  RecordingResult made = recording(file, 1e6, Severity::caution);
  made.trial.tilt.emplace().is_other_size = true;
  return made;
}

/// Adds a recording of `person` in `group`.
void add(Report& report, GroupTable& table, const std::string& group, const std::string& participant,
         RecordingResult made) {
  report.recordings.push_back(std::move(made));
  table.members.push_back({group, participant});
}

Json compared(Report& report, GroupTable table) {
  report.groups = decid::report_groups(std::move(table), report);
  return decid::tools::groups_json(report);
}

}  // namespace

TEST_CASE("people are compared by the recordings that can be used, the others are named") {
  Report report;
  GroupTable table{"subject", {}, {{7, "gone.csv"}}};
  // The means of people are 856.8 +- 63.4 of five in "a" and 724.5 +- 62.2 of four in "b".
  const double a[]{812, 905, 777, 860, 930}, b[]{700, 655, 742, 801};
  for (const double mean : a)
    for (const double off : {-40.0, 0.0, 40.0})
      add(report, table, "a", "a" + std::to_string(mean), recording("f", mean + off, Severity::caution));
  for (const double mean : b) add(report, table, "b", "b" + std::to_string(mean), recording("f", mean));
  add(report, table, "b", "b1", recording("bad.csv", 1e6, Severity::invalid));
  add(report, table, "a", "a1", of_other_tilt("twice.csv"));
  RecordingResult broken;
  broken.file = "broken.csv";
  broken.error = decid::Error(decid::Code::file_damaged, "broken.csv", "none", "try");
  add(report, table, "b", "b2", broken);
  add(report, table, "", "", recording("elsewhere.csv", 1e6));

  const Json found = compared(report, table);
  REQUIRE(found["groups"].size() == 2);
  CHECK(found["groups"][0]["name"] == "a");
  CHECK(found["groups"][0]["participants"] == 5);
  CHECK(found["groups"][0]["recordings"] == 15);
  CHECK(found["groups"][1]["participants"] == 4);
  CHECK(near(found["groups"][0]["parameters"][3]["sd"].get<double>(), 63.37744078140107, 1e-14));
  REQUIRE(found["comparisons"].size() == 1);
  CHECK(found["comparisons"][0]["groups"] == Json{"a", "b"});
  CHECK(found["comparisons"][0]["paired"] == false);
  CHECK(found["comparisons"][0]["participants"] == Json{5, 4});
  const Json& last = found["comparisons"][0]["parameters"][6];
  CHECK(last["name"] == "delay");
  CHECK(near(last["difference"].get<double>(), 132.3, 1e-13));
  CHECK(near(last["hedges_g"].get<double>(), 1.870954512360277, 1e-13));
  CHECK(near(last["interval95"][1].get<double>(), 232.90206246259245, 1e-12));
  CHECK(near(last["adjusted_interval95"][1].get<double>(), 293.49617439784564, 1e-12));
  const Json& settings = found["group_comparison"];
  CHECK(settings["participant_column"] == "subject");
  CHECK(settings["parameters"] == 7);
  CHECK(settings["intervals"] == 7);
  CHECK(settings["adjustment"] == "bonferroni");
  CHECK(settings["left_out"] == Json{{{"file", "bad.csv"}, {"group", "b"}, {"reason", "not usable"}},
                                     {{"file", "twice.csv"}, {"group", "a"}, {"reason", "tilt_of_other_size"}},
                                     {{"file", "broken.csv"}, {"group", "b"}, {"reason", "error"}}});
  CHECK(settings["unused_lines"] == Json{{{"line", 7}, {"file", "gone.csv"}}});
  CHECK(settings["bodies_differ"] == false);
  CHECK(settings["assumed_bodies"] == 19);
  CHECK(settings["mgh"] == report.protocol.experiment.body.mgh());
  CHECK(found["hierarchical"].is_null());  // without distributions
  CHECK(found["reliability"].is_array());
  const Json recordings = decid::tools::recordings_json(report);
  CHECK(recordings[0]["group"] == "a");
  CHECK(recordings[20]["participant_id"] == "a1");
  CHECK_FALSE(recordings[22].contains("group"));

  const std::string text = groups_text(report);
  CAPTURE(text);
  CHECK(contains(text, "a: 5 people, 15 recordings\n    Kp              856.8 +- 63.4 N m/rad\n"));
  CHECK(contains(text, "a minus b: 5 people and 4 people"));
  CHECK(contains(text, "7 parameters were compared"));
  CHECK(contains(text, "Left out: 3 recordings"));
  CHECK(contains(text, "twice.csv (a): tilt_of_other_size"));
  CHECK(groups_text({}).empty());
  CHECK(decid::tools::summary_text(report).starts_with(
      "23 recordings: 5 usable, 16 caution, 1 not usable, 1 not analysed\nDo the groups differ?"));
  CHECK(decid::tools::summary_text({}).empty());

  const Json page = decid::tools::page_groups(report);
  REQUIRE(page["members"].size() == 22);
  CHECK(page["members"][20] == Json{{"group", "a"}, {"left_out", "tilt_of_other_size"}});
  CHECK(page["members"][21] == Json{{"group", ""}, {"left_out", ""}});
  CHECK(decid::tools::page_groups({}).is_null());
}

TEST_CASE("fixed parameters are not compared: text and JSON name them") {
  Report report;
  GroupTable table{"subject", {}};
  for (const auto& [group, participant, value] : {std::tuple("a", "s1", 700.0), {"a", "s2", 655.0}, {"b", "s3", 742.0}})
    add(report, table, group, participant, recording("f", value));
  report.fit.emplace().priors.parameters = {{.name = "Kd", .fixed = 250.0}, {.name = "Kp", .fixed = 839.0}};
  const Json found = compared(report, table);
  const Json& settings = found["group_comparison"];
  CHECK(settings["fixed_parameters"] == Json{"Kp", "Kd"});  // in the controller's order
  CHECK(settings["parameters"] == 5);
  CHECK(settings["intervals"] == 5);
  for (const Json& parameters : {found["groups"][0]["parameters"], found["comparisons"][0]["parameters"]}) {
    REQUIRE(parameters.size() == 5);
    CHECK(parameters[0]["name"] == "Kp_pass");
    CHECK(parameters[4]["name"] == "delay");
  }
  CHECK(found["comparisons"][0]["parameters"][0]["difference"] == 677.5 - 742.0);
  const std::string text = groups_text(report);
  CAPTURE(text);
  CHECK(contains(text, "not compared: Kp, Kd\n"));
  CHECK_FALSE(contains(text, "Kd  "));
  CHECK(contains(text, "5 parameters were compared"));
  // Every recording that the hierarchical model lacks has a reason.
  CHECK(settings["without_distribution"].size() == 3);
  CHECK(settings["without_distribution_reasons"] == Json{"no_distribution", "no_distribution", "no_distribution"});
  CHECK(contains(text, "Not in the hierarchical model: 3 recordings\n    f: "));
  report.fit.reset();
  CHECK(compared(report, table)["group_comparison"]["fixed_parameters"].empty());
}

TEST_CASE("people in two groups are compared in pairs, and the text says so") {
  Report report;
  GroupTable table{"participant_id", {}};
  for (const auto& [participant, before, after] :
       {std::tuple("s1", 700.0, 812.0), {"s2", 655.0, 905.0}, {"s3", 742.0, 777.0}}) {
    add(report, table, "before", participant, recording("f", before));
    add(report, table, "after", participant, recording("f", after));
  }
  add(report, table, "before", "s4", recording("f", 1e5));
  const Json found = compared(report, table);
  const Json& pair = found["comparisons"][0];
  CHECK(pair["paired"] == true);
  CHECK(pair["participants"] == Json{3, 3});
  CHECK(pair["unpaired_participants"] == 1);
  CHECK(near(pair["parameters"][0]["difference"].get<double>(), 397.0 / 3.0, 1e-14));
  const std::string text = groups_text(report);
  CHECK(contains(text, "paired: 3 people in both groups"));
  CHECK(contains(text, "without 1 person in only one"));
}

TEST_CASE("two people in two groups have an interval and no Hedges' g") {
  Report report;
  GroupTable table{"subject", {}};
  for (const auto& [participant, before, after] : {std::tuple("s1", 700.0, 812.0), {"s2", 655.0, 905.0}}) {
    add(report, table, "before", participant, recording("f", before));
    add(report, table, "after", participant, recording("f", after));
  }
  const Json found = compared(report, table);
  const Json& effect = found["comparisons"][0]["parameters"][0];
  CHECK(effect["hedges_g"].is_null());
  CHECK(effect["difference"] == 181.0);
  CHECK(effect["interval95"][0].is_number());
  CHECK(contains(groups_text(report), "         -\n"));
}

TEST_CASE("a group of one has no interval, and three groups have three comparisons") {
  Report report;
  GroupTable table;
  for (const char* group : {"a", "b", "c"})
    add(report, table, group, group, recording("f", static_cast<double>(report.recordings.size())));
  const Json found = compared(report, table);
  REQUIRE(found["comparisons"].size() == 3);
  CHECK(found["group_comparison"]["participant_column"].is_null());
  CHECK(found["group_comparison"]["intervals"] == 21);
  CHECK(found["comparisons"][2]["groups"] == Json{"b", "c"});
  CHECK(found["comparisons"][1]["parameters"][0]["difference"] == -2.0);
  CHECK(found["comparisons"][1]["parameters"][0]["hedges_g"].is_null());
  CHECK(found["comparisons"][1]["parameters"][0]["interval95"][0].is_null());
  CHECK(found["groups"][0]["parameters"][0]["sd"].is_null());
  CHECK_FALSE(decid::tools::recordings_json(report)[0].contains("participant_id"));
  const std::string text = groups_text(report);
  CHECK(contains(text, "each recording counts as a person"));
  CHECK(contains(text, "in 3 pairs of groups"));
  CHECK(contains(text, "c: 1 person, 1 recording\n    Kp                  2 N m/rad\n"));
  CHECK_FALSE(contains(text, "+- -"));
  CHECK(contains(text, "one person: no"));
  CHECK(contains(text, "a group of one person: no interval"));
}

TEST_CASE("the text of a group without usable recordings has no values") {
  Report report;
  GroupTable table{"subject", {}};
  for (const char* group : {"a", "b"})
    for (const char* person : {"1", "2"})
      add(report, table, group, std::string(group) + person, recording("f", 700.0 + *person));
  add(report, table, "c", "c1", recording("bad.csv", 1e6, Severity::invalid));
  compared(report, table);
  const std::string text = groups_text(report);
  CAPTURE(text);
  CHECK(contains(text, "  c: 0 people, 0 recordings\n    no usable recording\n  a minus b"));
}

TEST_CASE("values that are the same for all people have no interval, and the text says so") {
  Report report;
  GroupTable table{"subject", {}};
  for (const auto& [group, participant] : {std::tuple("a", "s1"), {"a", "s2"}, {"b", "s3"}, {"b", "s4"}})
    add(report, table, group, participant, recording("f", 700.0));
  compared(report, table);
  CHECK(contains(groups_text(report), "identical values"));
  CHECK(contains(groups_text(report), "no interval of Kp"));
}

TEST_CASE("group_verdicts: the parameters whose deciding interval leaves out 0, in people's units") {
  Report report;
  decid::GroupComparison& comparison = report.groups.emplace().comparison;
  comparison.groups.resize(2);
  comparison.groups[0].name = "patients";
  comparison.groups[1].name = "controls";
  decid::GroupPair pair;
  pair.second = 1;
  pair.participants = {1, 8};
  decid::GroupEffect effect;
  effect.difference = 1.0;
  effect.adjusted_interval95 = {-1.0, 3.0};
  pair.parameters.assign(7, effect);
  effect.difference = -90.0;
  effect.adjusted_interval95 = {-160.0, -20.0};
  pair.parameters[0] = effect;
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  effect.difference = 1.0;
  effect.adjusted_interval95 = {unknown, unknown};
  pair.parameters[4] = effect;
  effect.difference = 0.021;
  effect.adjusted_interval95 = {0.005, 0.037};
  pair.parameters[6] = effect;
  comparison.pairs = {pair};
  const decid::tools::GroupVerdicts found = decid::tools::group_verdicts(report);
  REQUIRE(found.sentences.size() == 1);
  CAPTURE(found.sentences[0]);
  for (const char* fact :
       {"Kp: controls higher, 90 N m/rad [20, 160]", "delay: patients longer, 21 ms [5, 37]",
        "no difference shown in: Kd, Kp_pass, Kd_pass, theta", "no interval of: Nv (too few people)"})
    CHECK(contains(found.sentences[0], fact));
  comparison.pairs[0].participants = {8, 8};
  CHECK(contains(decid::tools::group_verdicts(report).sentences[0],
                 "no interval of: Nv (identical values of all people)"));
  CHECK(contains(found.intervals, "adjusted"));
  CHECK(decid::tools::group_verdicts({}).sentences.empty());
}

TEST_CASE(
    "verdicts: notes on people, on groups of one person and on marks of exclusion; numbers are group 0 and group 1") {
  Report report;
  GroupTable table{"", {}};
  table.other_columns = {"Tester", "age"};
  const auto add_group = [&](const std::string& group, int count, double value) {
    for (int i = 0; i < count; ++i) add(report, table, group, group + std::to_string(i), recording("f", value + i));
  };
  add_group("0", 3, 700.0);
  add_group("1", 3, 900.0);
  report.groups = decid::report_groups(table, report);
  decid::tools::GroupVerdicts found = decid::tools::group_verdicts(report);
  REQUIRE(found.sentences.size() == 1);
  CHECK(contains(found.sentences[0], "group 0 and group 1: Kp: group 1 higher"));
  REQUIRE(found.notes.size() == 1);
  CHECK(contains(found.notes[0], "each recording counts as a person"));
  CHECK(contains(found.notes[0], "Tester, age"));
  CHECK(contains(verdicts_text(report), found.notes[0] + "\n  group 0 and group 1"));

  report = {};
  table = {"subject", {}};
  add_group("patients", 3, 700.0);
  add_group("controls", 3, 900.0);
  add_group("patient", 1, 700.0);
  add_group("Excluded", 2, 100.0);
  const Json json = compared(report, table);
  CHECK(json["comparisons"].size() == 3);
  CHECK(json["group_comparison"]["intervals"] == 21);
  CHECK(json["group_comparison"]["too_small_groups"] == Json{"patient"});
  found = decid::tools::group_verdicts(report);
  CHECK(found.sentences.size() == 3);
  REQUIRE(found.notes.size() == 2);
  CHECK(contains(found.notes[0], "Group 'patient' has one person: a typo of 'patients'?"));
  CHECK(contains(found.notes[1], "'Excluded'"));
  CHECK(decid::tools::page_groups(report)["verdicts"]["notes"].size() == 2);

  report = {};
  table = {"subject", {}};
  table.has_groups = false;
  for (const char* session : {"1", "10", "2"})
    for (const char* person : {"a", "b"}) {
      add(report, table, "all", person, recording("f", 700.0 + *person * std::stod(session)));
      table.members.back().session = session;
    }
  report.groups = decid::report_groups(table, report);
  found = decid::tools::group_verdicts(report);
  REQUIRE(found.sentences.size() == 3);
  CHECK(found.sentences[0].starts_with("session 1 and session 2: "));
  CHECK(found.sentences[2].starts_with("session 2 and session 10: "));
  CHECK(found.notes.empty());
}

TEST_CASE("groups of recordings with distributions also have a hierarchical model") {
  Report report;
  GroupTable table{"subject", {}};
  std::vector<double> outputs;
  for (const char* group : {"a", "b"})
    for (int i = 0; i < 3; ++i) {
      outputs.assign(1, 0.0);
      outputs.resize(8, 0.3 * i + (*group == 'a' ? 0.8 : -0.8));
      outputs.resize(15, 1.2);  // sd of a coordinate: exp(-1.2)
      outputs.resize(decid::mixture_outputs(1, 7), 0.0);
      RecordingResult made = recording("f", 900.0 + i);
      made.estimate.distribution = decid::ParameterDistribution(decid::Mixture(1, 7, outputs), report.ranges());
      add(report, table, group, "s" + std::to_string(i), made);
    }
  const Json found = compared(report, table);
  const Json& model = found["hierarchical"];
  CHECK(model["draws"] == 4000);
  CHECK(model["max_rhat"].get<double>() < 1.2);
  CHECK(model["groups"][0]["participants"] == 3);
  CHECK(model["groups"][1]["parameters"][6]["between_sd"].get<double>() > 0.0);
  const Json& pair = model["comparisons"][0];
  CHECK(pair["groups"] == Json{"a", "b"});
  CHECK(pair["participants_in_both"] == 3);
  const Json& effect = pair["parameters"][6];
  CHECK(effect["name"] == "delay");
  CHECK(effect["difference"].get<double>() > 0.05);
  CHECK(effect["simultaneous95"][0] <= effect["interval95"][0]);
  CHECK(effect["probability_of_direction"].get<double>() > 0.9);
  CHECK(model["variance"][0]["trial_sd"] == 0.0);
  CHECK(model["changes"].size() == 3);
  CHECK(model["changes"][0]["parameters"][0].contains("changed"));
  REQUIRE(found["reliability"].size() == 1);
  CHECK(found["reliability"][0]["participants"] == 3);
  CHECK(found["reliability"][0]["parameters"][0]["icc_single"] == 1.0);  // the values agree exactly
  const std::string text = groups_text(report);
  CAPTURE(text);
  CHECK(contains(text, "hierarchical model"));
  CHECK(contains(text, "    delay, s "));  // rows have units
  CHECK_FALSE(contains(text, "Do the groups differ?"));
  CHECK(verdicts_text(report).find("Do the groups differ?") == 0);
  const std::string whole = report_text(report);  // the verdicts stand above the recordings
  CHECK(whole.starts_with("6 recordings: 6 usable\nDo the groups differ?"));
  CHECK(whole.find("Groups: mean") > whole.find("f ()"));
  CHECK(decid::tools::page_groups(report)["verdicts"]["sentences"].size() == 1);
  CHECK(contains(text, "a minus b, 3 people in both"));
  CHECK(decid::tools::page_groups(report)["hierarchical"]["draws"] == 4000);
}

TEST_CASE("verdicts: notes on conditions that differ between groups, on sessions of one person, on unclear dates") {
  Report report;
  GroupTable table{"subject", {}};
  double value = 700.0;
  const auto add_one = [&](const std::string& group, const std::string& person, const std::string& session,
                           const std::string& condition) {
    add(report, table, group, person, recording("f", value += 1.0));
    table.members.back().sheet_session = session;
    table.members.back().sheet_condition = condition;
  };
  const auto notes = [&] {
    report.groups = decid::report_groups(table, report);
    return decid::tools::group_verdicts(report).notes;
  };
  for (const char* person : {"a", "b"})
    for (const char* condition : {"EO", "EC"}) add_one("patients", person, "", condition);
  for (const char* person : {"c", "d"}) add_one("controls", person, "", "EO");
  std::vector<std::string> found = notes();
  REQUIRE(found.size() == 1);
  for (const char* fact : {"different conditions (recordings of controls: 2 of EO; patients: 2 of EC, 2 of EO)",
                           "give the table as ", "within condition), or leave recordings out"})
    CHECK(contains(found[0], fact));
  CHECK(decid::tools::groups_json(report)["group_comparison"]["notes"] == Json(found));
  CHECK(decid::tools::page_groups(report)["verdicts"]["notes"] == Json(found));
  report.sheet.emplace();
  for (const char* person : {"c", "d"}) add_one("controls", person, "", "EC");
  CHECK(notes().empty());
  for (const char* person : {"c", "d"}) add_one("controls", person, "", "EC");
  CHECK(notes().empty());  // a share of 2/3 instead of 1/2
  for (int i = 0; i < 6; ++i) add_one("controls", "c", "", "EC");
  found = notes();
  REQUIRE(found.size() == 1);
  CHECK(contains(found[0], "compare these too ("));
  CHECK_FALSE(contains(found[0], "give the table as"));
  for (decid::GroupMember& member : table.members) {
    member.session = "1";  // is compared
    if (member.group == "controls") member.sheet_session = "2";
  }
  found = notes();
  REQUIRE(found.size() == 1);
  CHECK(contains(found[0], "within session,condition)"));
  for (decid::GroupMember& member : table.members) member.condition = member.sheet_condition;
  CHECK(notes().empty());

  // Each person has dates of its own: one note for all, instead of one per date.
  report = {};
  table = {"subject", {}};
  table.has_groups = false;
  for (const char* person : {"a", "b"})
    for (const char* session : {"1", "2"}) {
      add_one("all", person, person + std::string(session), "");
      table.members.back().session = table.members.back().sheet_session;
    }
  found = notes();
  REQUIRE(found.size() == 1);
  CHECK(contains(found[0], "Most sessions have one person alone (a1, a2, b1, b2)"));
  CHECK(contains(found[0], "number each person's visits (1, 2)"));
  // A session without a recording that can be used has a note of its own.
  const auto add_unusable = [&](const std::string& person, const std::string& session) {
    add_one("all", person, session, "");
    table.members.back().session = session;
    report.recordings.back().error = decid::Error(decid::Code::file_missing, "f", "is missing", "name another");
  };
  add_unusable("c", "c1");
  found = notes();
  REQUIRE(found.size() == 2);
  CHECK(contains(found[0], "Most sessions have one person alone (a1, a2, b1, b2)"));
  CHECK(contains(found[1], "No recording of group 'c1' can be used"));
  table.members.pop_back();
  report.recordings.pop_back();
  const auto with_dates = [&](const std::string& first, const std::string& second) {
    for (decid::GroupMember& member : table.members)
      member.session = member.sheet_session.ends_with("1") ? first : second;
    return notes();
  };
  CHECK(with_dates("10.01.2023", "09.02.2023").empty());
  CHECK(report.groups->comparison.groups[0].name == "10.01.2023");
  CHECK(with_dates("13/01/2023", "09/02/2023").empty());
  found = with_dates("01/10/2023", "09/02/2023");
  REQUIRE(found.size() == 1);
  CHECK(contains(found[0], "Session 01/10/2023 is ordered as day, month and year"));
}
