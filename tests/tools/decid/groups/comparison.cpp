// Groups of recordings as reported: text, JSON and page.
#include <algorithm>
#include <tuple>

#include "base/error.hpp"
#include "tests/tools/decid/groups/compared.hpp"
#include "tools/decid/results/group_results.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/report/json/group_verdicts.hpp"

using decid::GroupTable;
using decid::Json;
using decid::RecordingResult;
using decid::Report;
using decid::Severity;
using namespace decid::test;
using decid::tools::groups_text;
using decid::tools::report_text;

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
  add(report, table, "", "a1", recording("unsorted.csv", 1e6));
  table.members.back().missing = "session";

  const Json found = compared(report, table);
  REQUIRE(found["groups"].size() == 2);
  CHECK(found["groups"][0]["name"] == "a");
  CHECK(found["groups"][0]["participants"] == 5);
  CHECK(found["groups"][0]["recordings"] == 15);
  CHECK(found["groups"][1]["participants"] == 4);
  REQUIRE(found["comparisons"].size() == 1);
  CHECK(found["comparisons"][0]["groups"] == Json{"a", "b"});
  CHECK(found["comparisons"][0]["paired"] == false);
  CHECK(found["comparisons"][0]["participants"] == Json{5, 4});
  const Json& last = found["comparisons"][0]["parameters"][6];
  CHECK(last["name"] == "delay");
  CHECK(near(last["difference"].get<double>(), 132.3, 1e-13));
  CHECK(near(last["adjusted_interval95"][1].get<double>(), 293.49617439784564, 1e-12));
  const Json& settings = found["group_comparison"];
  CHECK(settings["participant_column"] == "subject");
  CHECK(settings["parameters"] == 7);
  CHECK(settings["intervals"] == 7);
  CHECK(settings["adjustment"] == "bonferroni");
  CHECK(settings["left_out"] == Json{{{"file", "bad.csv"}, {"group", "b"}, {"reason", "not usable"}},
                                     {{"file", "twice.csv"}, {"group", "a"}, {"reason", "tilt_of_other_size"}},
                                     {{"file", "broken.csv"}, {"group", "b"}, {"reason", "error"}},
                                     {{"file", "unsorted.csv"}, {"group", nullptr}, {"reason", "without_session"}}});
  CHECK(settings["unused_lines"] == Json{{{"line", 7}, {"file", "gone.csv"}}});
  CHECK(settings["bodies_differ"] == false);
  CHECK(settings["assumed_bodies"] == 19);
  CHECK(settings["mgh"] == report.protocol.experiment.body.mgh());
  CHECK(found["hierarchical"].is_null());  // without distributions
  const Json recordings = decid::tools::recordings_json(report);
  CHECK(recordings[0]["group"] == "a");
  CHECK(recordings[20]["participant_id"] == "a1");
  CHECK_FALSE(recordings[22].contains("group"));

  CHECK(contains(groups_text(report), "    unsorted.csv: without_session\n"));
  CHECK(contains(groups_text(report), "a: 5 people, 15 recordings\n    Kp              856.8 +- 63.4 N m/rad\n"));
  CHECK(groups_text({}).empty());
  CHECK(decid::tools::summary_text(report).starts_with("24 recordings: 6 usable, 16 caution, 1 not usable, 1 not"));
  CHECK(decid::tools::summary_text({}).empty());

  const Json page = decid::tools::page_groups(report);
  REQUIRE(page["members"].size() == 23);
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
  CHECK_FALSE(contains(groups_text(report), "Kd  "));
  // Every recording that the hierarchical model lacks has a reason.
  CHECK(settings["without_distribution"].size() == 3);
  CHECK(settings["without_distribution_reasons"] == Json{"no_distribution", "no_distribution", "no_distribution"});
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
  CHECK(contains(groups_text(report), "paired: 3 people in both groups"));
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
  CHECK(contains(text, "c: 1 person, 1 recording\n    Kp                  2 N m/rad\n"));
  CHECK_FALSE(contains(text, "+- -"));
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
  CHECK(contains(text, "    delay, s "));  // rows have units
  CHECK(contains(text, "  a and b: 3 people in both\n"));
  CHECK(contains(text, "    Kp, N m/rad             1.00    1.00 to 1.00          0          0"));
  CHECK(contains(text, "\n    s0 "));  // a change that is found has a star: delay, not Kp
  const std::string person = text.substr(text.find("\n    s0 "), text.find("\n    s1 ") - text.find("\n    s0 "));
  CHECK(std::ranges::count(person, '*') ==
        std::ranges::count_if(model["changes"][0]["parameters"],
                              [](const Json& one) { return one["changed"].get<bool>(); }));
  CHECK(std::ranges::count(person, '*') > 0);
  CHECK(contains(text, "The 21 intervals are not adjusted"));  // three people, seven parameters
  const std::size_t above = text.rfind('\n', text.find("\n    s0 ") - 1);
  const std::string heading = text.substr(above, text.find("\n    s0 ") - above);
  CHECK(contains(heading, " Kp, N m/rad "));
  CHECK(heading.size() == person.find('\n', 1));  // the columns stand below their headings
  CHECK(contains(person, "\n      own "));
  const std::string whole = report_text(report);  // the verdicts stand above the recordings
  CHECK(whole.starts_with("6 recordings: 6 usable\nWhat differs?"));
  CHECK(whole.find("Groups: mean") > whole.find("f ()"));
  CHECK(decid::tools::page_groups(report)["verdicts"]["sentences"].size() == 1);
  CHECK(decid::tools::page_groups(report)["hierarchical"]["draws"] == 4000);
}

TEST_CASE("a person who does not change among people who do has no star") {
  // Recordings are uncertain, so the hierarchical model moves s0 towards the change of the others.
  Report report;
  GroupTable table{"subject", {}};
  for (const bool is_first : {true, false})
    for (int i = 0; i < 10; ++i) {
      std::vector<double> outputs(1, 0.0);
      outputs.resize(7, 0.0);
      outputs.push_back(is_first || i == 0 ? 0.5 : -0.9);  // of the delay's coordinate
      outputs.resize(15, 0.7);
      outputs.resize(decid::mixture_outputs(1, 7), 0.0);
      RecordingResult made = recording("f", 900.0);
      made.estimate.distribution = decid::ParameterDistribution(decid::Mixture(1, 7, outputs), report.ranges());
      made.estimate.parameters[6] = made.estimate.distribution->mean(6);
      add(report, table, is_first ? "1" : "2", "s" + std::to_string(i), made);
    }
  const Json found = compared(report, table);
  const Json& changes = found["hierarchical"]["changes"];
  REQUIRE(changes.size() == 10);
  REQUIRE(found["own_changes"].size() == 10);
  for (std::size_t i = 0; i < changes.size(); ++i) {
    CAPTURE(i);
    const Json &delay = changes[i]["parameters"][6], &own = found["own_changes"][i]["parameters"][6];
    CHECK(changes[i]["participant_id"] == found["own_changes"][i]["participant_id"]);
    CHECK(delay["own_difference"] == own["difference"]);
    CHECK(delay["own_interval95"] == own["interval95"]);
    CHECK(delay["interval95"][0].get<double>() > 0.0);
    CHECK(delay["changed"] == own["changed"]);
    CHECK(delay["changed"] == (i != 0));
  }
}

TEST_CASE("people compared in several sessions have a heading for each pair of sessions") {
  Report report;
  GroupTable table{"subject", {}};
  std::vector<double> outputs(8, 0.0);
  outputs.resize(15, 1.2);
  outputs.resize(decid::mixture_outputs(1, 7), 0.0);
  for (const char* session : {"1", "2", "3"})
    for (int i = 0; i < 2; ++i) {
      RecordingResult made = recording("f", 900.0);
      made.estimate.distribution = decid::ParameterDistribution(decid::Mixture(1, 7, outputs), report.ranges());
      add(report, table, session, "s" + std::to_string(i), made);
    }
  compared(report, table);
  const std::string text = groups_text(report), changes = text.substr(text.find("Changes of each person"));
  for (const char* pair : {"\n  1 minus 2\n", "\n  1 minus 3\n", "\n  2 minus 3\n"}) {
    CAPTURE(pair);
    REQUIRE(contains(changes, pair));
    CHECK(changes.find(pair) == changes.rfind(pair));
  }
}

TEST_CASE("one person's two visits have a change with its interval") {
  Report report;
  GroupTable table{"subject", {}};
  for (const double at : {0.8, -0.8}) {
    std::vector<double> outputs(1, 0.0);
    outputs.resize(7, 0.0);
    outputs.push_back(at);  // of the delay's coordinate
    outputs.resize(15, 1.2);
    outputs.resize(decid::mixture_outputs(1, 7), 0.0);
    RecordingResult made = recording("f", 900.0);
    made.estimate.distribution = decid::ParameterDistribution(decid::Mixture(1, 7, outputs), report.ranges());
    made.estimate.parameters[6] = made.estimate.distribution->mean(6);
    add(report, table, at > 0.0 ? "1" : "2", "s", made);
  }
  const Json found = compared(report, table);
  CHECK(found["hierarchical"].is_null());
  CHECK(found["reliability"].empty());
  REQUIRE(found["own_changes"].size() == 1);
  const Json& change = found["own_changes"][0];
  CHECK(change["participant_id"] == "s");
  CHECK(change["groups"] == Json{"1", "2"});
  REQUIRE(change["parameters"].size() == 7);
  CHECK(change["parameters"][0]["difference"] == 0.0);
  CHECK(change["parameters"][0]["changed"] == false);
  CHECK(change["parameters"][6]["difference"].get<double>() > 0.05);
  CHECK(change["parameters"][6]["interval95"][0].get<double>() > 0.0);
  CHECK(change["parameters"][6]["changed"] == true);
  const std::string text = groups_text(report);
  CHECK_FALSE(contains(text, "ICC"));
  CHECK(contains(text, "  s: 1 minus 2\n"));
  CHECK(contains(text, "The 7 intervals are not adjusted"));
  CHECK(contains(text, "  changed\n"));
  CHECK(decid::tools::page_groups(report)["own_changes"] == found["own_changes"]);
  CHECK(change["caution"] == false);
  CHECK_FALSE(contains(text, "caution"));
  decid::add_warning(report.recordings[1].warnings, decid::Severity::caution, "slow_sway", "moves slowly");
  CHECK(compared(report, table)["own_changes"][0]["caution"] == true);
  CHECK(contains(groups_text(report), "a recording has a caution"));
}
