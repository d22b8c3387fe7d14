// Groups, sessions, conditions, covariates and joint fits of a study's sheet.
#include "identify/study/plan_groups.hpp"

#include <doctest/doctest.h>

#include <cmath>

#include "identify/study/joint_groups.hpp"
#include "identify/study/recording_plan.hpp"
#include "sim/body_model.hpp"
#include "tests/helpers.hpp"
#include "tests/identify/study/sheet_files.hpp"

using namespace decid;
using namespace decid::test;

TEST_CASE("read_freed: parameters and a column; what is not so is refused") {
  const sim::ParameterTable& table = sim::single_pendulum().parameters;
  const FreedParameters freed = read_freed("theta,Nv,Kp:eyes", table);
  CHECK(freed.names == std::vector<std::string>{"theta", "Nv", "Kp"});
  CHECK(freed.conditions == "eyes");
  CHECK(read_freed("", table).names.empty());
  for (const char* text : {"theta", ":eyes", "theta:"})
    check_error([&] { read_freed(text, table); }, Code::setting_malformed);
  for (const char* text : {"theta,:eyes", "G_f:eyes", "theta,Nv Kp:eyes"})
    check_error([&] { read_freed(text, table); }, Code::setting_unknown);
}

TEST_CASE("StudySheet::reader_of: columns by any spelling; joint_groups: persons and conditions by any case") {
  const TemporaryFolder folder;
  const std::filesystem::path path = write_text(
      folder / "people.csv", "Subject,file,Eyes\nA,a.csv,open\na,b.csv,Open\nB,c.csv,open\na,d.csv,closed\n");
  const StudySheet sheet = read_sheet(path);
  CHECK(sheet.reader_for("participant_id")(sheet.lines[0].entry) == "A");
  CHECK(sheet.reader_for("eyes")(sheet.lines[1].entry) == "Open");
  check_error([&] { sheet.reader_for("shoe"); }, Code::column_missing, "shoe");
  check_error([&] { sheet.reader_for("file"); }, Code::column_missing, "file");
  const RecordingPlan plan =
      make_plan(sheet, sources(folder, {"a.csv", "b.csv", "c.csv", "d.csv"}), Choice::by_sheet, {});
  const std::vector<FitGroup> groups = joint_groups(plan, "subject", "eyes");
  REQUIRE(groups.size() == 1);
  CHECK(groups[0].recordings == std::vector<std::size_t>{0, 1, 3});
  CHECK(groups[0].conditions == std::vector<std::string>{"open", "open", "closed"});
  check_error([&] { joint_groups(make_plan(sources(folder, {"a.csv"}), {}), "subject", ""); }, Code::setting_conflict);
}

TEST_CASE("groups of a plan: a sheet without groups, and a wrong cell, are named instead of a number of groups") {
  const TemporaryFolder folder;
  const auto plan = [&](const std::string& sheet) {
    return plan_of_text(folder, sheet, {"a.csv", "b.csv"}, Choice::by_sheet);
  };
  const RecordingPlan without = plan("ID\tfile\tdiagnosis\nA\ta.csv\tx\nB\tb.csv\ty\n");
  check_error([&] { groups_of_plan(without, true); }, Code::column_missing, "ID, file, diagnosis");
  CHECK(groups_of_plan(without, false).members.size() == 2);
  const RecordingPlan wrong = plan("ID\tfile\tGroup\tweight\theight\nA\ta.csv\tx\t70\t17\nB\tb.csv\tx\t70\t175\n");
  const GroupTable groups = groups_of_plan(wrong, true);
  check_error([&] { refuse_groups(groups.members, "here", 2, &wrong); }, Code::value_invalid, "'17'");
  check_error([&] { refuse_groups(groups.members, "here", 2); }, Code::setting_out_of_range, "1 group");
  refuse_groups(groups.members, "here", 1, &wrong);
}

TEST_CASE("add_covariate: what the model of groups cannot tell is refused") {
  const TemporaryFolder folder;
  const RecordingPlan plan =
      plan_of_text(folder,
                   "participant_id\tgroup\tsession\tfile\tage\tof_group\tof_trial\tof_some\tcode\tsteps\n"
                   "A\tx\t1\ta.csv\t60\t1\t0\t5\t60\t999\n"
                   "A\tx\t2\tb.csv\t60\t1\t1\t5\t60\t999\n"
                   "B\tx\t1\tc.csv\t70\t1\t0\t6\t-99\t1450\n"
                   "C\ty\t1\td.csv\t65\t0\t0\tn/a\t65\t700\n",
                   {"a.csv", "b.csv", "c.csv", "d.csv"}, Choice::by_sheet);
  const auto add = [&](const char* column, bool within) {
    GroupTable groups = groups_of_plan(plan, true);
    if (within) compare_within("session", plan, groups);
    add_covariate(column, plan, groups);
  };
  CHECK_NOTHROW(add("age", false));
  CHECK_NOTHROW(add("age", true));
  check_error([&] { add("of_group", false); }, Code::value_invalid, "of_group");
  check_error([&] { add("of_trial", false); }, Code::value_invalid, "participant A");
  check_error([&] { add("of_trial", true); }, Code::value_invalid, "one value");  // it is the session
  check_error([&] { add("of_some", false); }, Code::value_missing, "group y");
  check_error([&] { add("code", false); }, Code::value_invalid, "-99");
  CHECK_NOTHROW(add("steps", false));  // 999 is among the others
  for (const char* age : {"0", "0,9", "121", "660", "1958", "-5"}) {
    CAPTURE(age);
    const RecordingPlan ages = plan_of_text(
        folder,
        "participant_id\tfile\tAlter\tcode\nA\ta.csv\t60\t60\nB\tb.csv\t" + std::string(age) + "\t" + age + "\n",
        {"a.csv", "b.csv"}, Choice::by_sheet);
    check_error([&] { read_covariate(ages, "Alter"); }, Code::value_invalid, std::string("'") + age + "'");
    CHECK(read_covariate(ages, "code").size() == 2);
  }
}

TEST_CASE("groups of a plan: sessions, conditions and covariates of its sheet") {
  const TemporaryFolder folder;
  const std::vector<std::string> files{"a.csv", "b.csv", "c.csv", "d.csv"};
  const RecordingPlan plan = plan_of_text(folder,
                                          "participant_id\tgroup\tsession\tcondition\tfile\tage\tweight\theight\tsex\n"
                                          "A\tx\t1\topen\ta.csv\t60,5\t70\t175\tF\n"
                                          "a\tX\t2\tOpen\tb.csv\t61\t71\t175\tM\n"
                                          "B\ty\t1\topen\tc.csv\tn/a\tn/a\tn/a\tn/a\n"
                                          "C\tn/a\tn/a\tn/a\td.csv\t50\t80\t1.8\tF\n"
                                          "D\ty\t1\topen\te.csv\t55\tn/a\tn/a\tF\n"
                                          "E\ty\t1\topen\tf.csv\t70\tn/a\tn/a\tF\n",
                                          {"a.csv", "b.csv", "c.csv", "d.csv", "e.csv", "f.csv"}, Choice::by_sheet);
  const std::vector<double> ages = read_covariate(plan, "Age"), weights = read_covariate(plan, "weight_kg");
  CHECK(ages[0] == 60.5);
  CHECK(std::isnan(ages[2]));
  CHECK(weights[3] == 80.0);
  CHECK(read_covariate(plan, "body height")[0] == 1.75);
  check_error([&] { read_covariate(plan, "sex"); }, Code::value_invalid, "'F'");
  check_error([&] { read_covariate(plan, "shoe"); }, Code::column_missing, "shoe");
  const auto steps = [&](const std::string& cells) {  // of four recordings
    return read_covariate(plan_of_text(folder, "steps\tfile\n" + cells, files, Choice::by_sheet), "steps");
  };
  check_error([&] { steps("7,500\ta.csv\n12,300\tb.csv\n980\tc.csv\nn/a\td.csv\n"); }, Code::value_invalid, "'7,500'");
  CHECK(steps("7,500\ta.csv\n12,3\tb.csv\n980\tc.csv\n0\td.csv\n") == std::vector<double>{7.5, 12.3, 980.0, 0.0});
  CHECK(steps("0,500\ta.csv\n1,250\tb.csv\n2\tc.csv\n1\td.csv\n") == std::vector<double>{0.5, 1.25, 2.0, 1.0});
  // Taille is carried along beside height, and is neither the height nor of its unit.
  const auto waist =
      plan_of_text(folder, "file\theight\tTaille (cm)\tweight\na.csv\t175\t85\t70\n", {"a.csv"}, Choice::by_sheet);
  CHECK(read_covariate(waist, "height")[0] == 1.75);
  check_error([&] { read_covariate(waist, "taille_cm"); }, Code::value_invalid, "the sheet's is another column");
  const RecordingPlan without = make_plan(sources(folder, {"a.csv"}), {});
  check_error([&] { read_covariate(without, "age"); }, Code::setting_missing, "covariates");

  GroupTable groups = groups_of_plan(plan, true);
  CHECK(groups.participant_column == "participant_id");
  CHECK(groups.members[1].group == "x");
  CHECK(groups.members[1].participant == "A");
  CHECK(groups.members[3].group.empty());
  refuse_groups(groups.members, "here");
  check_error([&] { refuse_groups(groups.members, "here", 3); }, Code::setting_out_of_range, "2 groups");
  CHECK(compare_within("session", plan, groups) == 0);
  CHECK(groups.members[1].cell() == "x, 2");
  CHECK(groups.members[3].cell().empty());
  check_error([&] { compare_within("condition", plan, groups); }, Code::value_missing, "1 condition");
  check_error([&] { compare_within("sex", plan, groups); }, Code::setting_unknown, "sex");
  check_error([&] { compare_within("session", without, groups); }, Code::setting_missing, "within");
  add_covariate("age", plan, groups);
  CHECK(groups.covariates == std::vector<std::string>{"age"});
  CHECK(groups.members[1].covariates == std::vector<double>{61.0});
  check_error([&] { add_covariate("height", plan, groups); }, Code::value_missing, "height");  // C is in no group

  GroupTable all = groups_of_plan(plan, false);
  CHECK(compare_within("session", plan, all) == 1);
  CHECK(all.members[0].cell() == "1");
  CHECK(all.members[3].cell().empty());
  const std::vector<FitGroup> joint = joint_groups(plan, "participant_id", "");
  check_error([&] { refuse_joint_cells(all, joint); }, Code::setting_conflict, "joint");
  refuse_joint_cells(groups_of_plan(plan, true), joint);
  refuse_joint_cells({}, joint);
  GroupTable one_cell = groups_of_plan(plan, true);
  one_cell.members[2].group = "x";
  check_error(
      [&] {
        refuse_joint_cells(one_cell, std::vector<FitGroup>{{{0, 2}, {}}});
      },
      Code::setting_conflict, "\"B\"");
}

TEST_CASE("groups of a plan: columns of a sheet that names nobody, and sessions 1 and 1.0") {
  const TemporaryFolder folder;
  const std::vector<std::string> files{"a.csv", "b.csv", "c.csv", "d.csv"};
  const GroupTable without =
      groups_of_plan(plan_of_text(folder, "file\tgroup\tTester\tage\na.csv\tx\tT\t60\nb.csv\ty\tT\t61\n",
                                  {"a.csv", "b.csv"}, Choice::by_sheet),
                     true);
  CHECK(without.participant_column.empty());
  CHECK(without.other_columns == std::vector<std::string>{"Tester", "age"});
  const RecordingPlan plan = plan_of_text(folder,
                                          "VP-Nr\tfile\tsession\n"
                                          "A\ta.csv\t1\nA\tb.csv\t10\nB\tc.csv\t1.0\nB\td.csv\t10.0\n",
                                          files, Choice::by_sheet);
  GroupTable groups = groups_of_plan(plan, false);
  CHECK(groups.participant_column == "VP-Nr");
  CHECK(groups.other_columns.empty());
  CHECK(compare_within("session", plan, groups) == 0);
  CHECK(groups.members[0].cell() == "1");
  CHECK(groups.members[2].cell() == "1");
  CHECK(groups.members[3].cell() == "10");
}

TEST_CASE("groups of a plan: labels that are one number or day are refused, recordings without one say which") {
  const TemporaryFolder folder;
  const std::vector<std::string> files{"a.csv", "b.csv", "c.csv", "d.csv"};
  const auto plan_with = [&](const std::string& one, const std::string& other) {
    return plan_of_text(folder,
                        "participant_id\tfile\tsession\tcondition\tgroup\nA\ta.csv\t" + one + "\t" + one +
                            "\tx\nA\tb.csv\t" + other + "\t" + other + "\tx\nB\tc.csv\t7\t7\ty\nC\td.csv\t\t\t\n",
                        files, Choice::by_sheet);
  };
  for (const auto& both : std::vector<std::pair<std::string, std::string>>{
           {"01", "1"}, {"5.3.2024", "2024-03-05"}, {"05/03/2024", "5/3/2024"}, {"Month 3", "month 03"}}) {
    const std::string &one = both.first, &other = both.second;
    CAPTURE(one);
    const RecordingPlan plan = plan_with(one, other);
    for (const char* column : {"session", "condition"}) {
      GroupTable groups = groups_of_plan(plan, false);
      check_error([&] { compare_within(column, plan, groups); }, Code::value_invalid, "participants.tsv, line 3");
    }
  }
  const RecordingPlan plan = plan_with("1", "2");
  GroupTable groups = groups_of_plan(plan, false);
  CHECK(compare_within("session", plan, groups) == 1);
  CHECK(groups.members[2].missing.empty());
  CHECK(groups.members[3].missing == "session");
  CHECK(groups_of_plan(plan, true).members[3].missing == "group");
  const RecordingPlan of_groups = plan_of_text(folder, "file\tgroup\na.csv\t01\nb.csv\t2\nc.csv\t1\n",
                                               {"a.csv", "b.csv", "c.csv"}, Choice::by_sheet);
  check_error([&] { groups_of_plan(of_groups, true); }, Code::value_invalid, "participants.tsv, line 4");
}

TEST_CASE("groups of a plan: lines without a participant, as of merged cells, are errors, and groups refuse them") {
  const TemporaryFolder folder;
  const std::vector<std::string> files{"a.csv", "b.csv", "c.csv", "d.csv"};
  const std::string merged = "Subject,file,group\nA,a.csv,x\n,b.csv,\nB,c.csv,y\n-,d.csv,\n";
  const std::filesystem::path path = write_text(folder / "s.csv", merged);
  for (const Choice choice : {Choice::by_sheet, Choice::by_call}) {
    const RecordingPlan plan = make_plan(read_sheet(path), sources(folder, files), choice, {});
    REQUIRE(plan.recordings.size() == 4);
    CHECK_FALSE(plan.recordings[0].error);
    check_has(plan.recordings[1].error, Code::value_missing, "line 3: has no Subject, and other lines have one");
    check_has(plan.recordings[3].error, Code::value_missing, "line 5");
    CHECK(plan.nameless == std::vector<std::size_t>{3, 5});
    for (const bool by_group : {true, false})
      check_error([&] { groups_of_plan(plan, by_group); }, Code::value_missing, "lines 3, 5: have no Subject");
  }
  // A footnote, which has an error of its own, is of no recording.
  const StudySheet noted =
      read_sheet(write_text(folder / "n.csv", "Subject,file,group\nA,a.csv,x\nB,c.csv,y\n,,end\n"));
  for (const Choice choice : {Choice::by_sheet, Choice::by_call}) {
    const RecordingPlan plan = make_plan(noted, sources(folder, {"a.csv", "c.csv"}), choice, {});
    CHECK(plan.nameless.empty());
    const GroupTable groups = groups_of_plan(plan, true);
    REQUIRE(groups.members.size() == plan.recordings.size());
    CHECK(groups.members[0].group == "x");
    CHECK(groups.members[1].group == "y");
    if (choice == Choice::by_sheet) {
      REQUIRE(plan.recordings.size() == 3);
      check_has(plan.recordings[2].error, Code::value_missing, "line 4");
    }
  }
  // A call without these lines, a table of groups, and a sheet without people.
  const StudySheet sheet = read_sheet(path);
  const RecordingPlan some = make_plan(sheet, sources(folder, {"a.csv", "c.csv"}), Choice::by_call, {});
  CHECK(groups_of_plan(some, true).members.size() == 2);
  const RecordingPlan table = make_plan(sheet, sources(folder, files), Choice::for_groups, {});
  CHECK_FALSE(table.recordings[1].error);
  CHECK(groups_of_plan(table, true).members[1].group.empty());
  const RecordingPlan nobody = make_plan(read_sheet(write_text(folder / "s.csv", "Subject,file\n,a.csv\n,b.csv\n")),
                                         sources(folder, files), Choice::by_sheet, {});
  CHECK_FALSE(nobody.recordings[0].error);
  CHECK(nobody.nameless.empty());
}
