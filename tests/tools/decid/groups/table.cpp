// The table of --group, which names the groups of recordings.
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "tests/tools/decid/run.hpp"
#include "tools/decid/group_file.hpp"

using decid::Code;
using decid::GroupTable;
using namespace decid::test;
using decid::tools::read_group_table;
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
