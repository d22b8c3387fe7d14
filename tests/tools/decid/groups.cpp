// Groups of recordings: the table that names them, and what is reported of them.
#include <doctest/doctest.h>

#include <cmath>

#include "base/error.hpp"
#include "base/json_object.hpp"
#include "sim/body_model.hpp"
#include "tests/near.hpp"
#include "tests/tools/decid/run.hpp"
#include "tools/decid/group_file.hpp"
#include "tools/decid/group_results.hpp"

using decid::Json;
using decid::test::Folder;
using decid::test::near;
using decid::test::write_text;
using decid::tools::groups_of;
using Names = std::vector<std::string>;

namespace {

Names read(const std::string& table, const Names& recordings) {
  const Folder folder;
  write_text(folder / "g.csv", table);
  return groups_of(folder / "g.csv", recordings);
}

std::string refusal(const std::string& table, const Names& recordings) {
  try {
    read(table, recordings);
  } catch (const decid::Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("groups are read from what spreadsheets write") {
  const Names recordings{"in/a.csv", "in/b.csv", "in/c.csv"}, groups{"old", "young, fit", ""};
  CHECK(read("file,group\na.csv,old\nb.csv,\"young, fit\"\nc.csv,\n", recordings) == groups);
  CHECK(read("\xEF\xBB\xBF"
             "Group;Age;File\r\nold;70;a.csv\r\n\"young, fit\";30;in/b.csv\r\n;;in/c.csv\r\n;;\r\n",
             recordings) == groups);
  CHECK(read("file\tgroup\n a.csv \told\n./in/b.csv\tyoung, fit\nin/c.csv\t\nd.csv\tnobody\n", recordings) == groups);
  CHECK(read("sep=;\r\nfile;group\r\na.csv;old\r\nb.csv;young, fit\r\nc.csv;\r\n", recordings) == groups);
  CHECK(read("group,file\n\"a \"\"x\"\"\",a.csv\nb,b.csv\nb,c.csv", recordings) == Names{"a \"x\"", "b", "b"});
}

TEST_CASE("a folder before its name tells two recordings of one name apart") {
  const Names recordings{"x/old/t.csv", "x/young/t.csv"};
  CHECK(read("file,group\nold/t.csv,a\nyoung/t.csv,b\n", recordings) == Names{"a", "b"});
  CHECK(refusal("file,group\nt.csv,a\nyoung/t.csv,b\n", recordings).find("line 3: x/young/t.csv is in group \"a\"") !=
        std::string::npos);
  // Names end where folders do.
  CHECK(refusal("file,group\nld/t.csv,a\ng/t.csv,b\n", recordings).find("no line for x/old/t.csv") !=
        std::string::npos);
}

TEST_CASE("groups that cannot be read are refused") {
  const Names recordings{"a.csv", "b.csv"};
  CHECK(refusal("name,group\na.csv,x\n", recordings).find("g.csv, line 1: has no column \"file\"") !=
        std::string::npos);
  CHECK(refusal("", recordings).find("no column") != std::string::npos);
  for (const char* empty : {"sep=;", "sep=;\n", "\n"})
    CHECK(refusal(empty, recordings).find("g.csv, line 1: has no column \"file\"") != std::string::npos);
  CHECK(refusal("file,group\na.csv\n", recordings).find("line 2: is too short") != std::string::npos);
  CHECK(refusal("file,group\n,x\n", recordings).find("line 2: names no file") != std::string::npos);
  CHECK(refusal("file,group\na.csv,x\n", recordings).find("no line for b.csv (it lacks 1 recording);") !=
        std::string::npos);
  CHECK(refusal("file,group\na.csv,x\nb.csv,x\n", recordings).find("in 1 group;") != std::string::npos);
  CHECK(refusal("file,group\na.csv,\nb.csv,\n", recordings).find("in 0 groups;") != std::string::npos);
}

TEST_CASE("groups are compared by the recordings that can be used") {
  const decid::sim::ParameterTable& table = decid::sim::single_pendulum().parameters;
  const auto recording = [&](double value, const char* trust) {
    Json made{{"file", "f"}, {"parameters", Json::array()}, {"trust", trust}};
    for (const std::string& name : table.names()) made["parameters"].push_back({{"name", name}, {"value", value}});
    return made;
  };
  Json recordings = Json::array({recording(700, "usable"), recording(812, "usable"), recording(905, "caution"),
                                 recording(655, "usable"), recording(777, "usable"), recording(1e6, "not usable"),
                                 recording(860, "usable"), recording(742, "usable"), recording(930, "usable"),
                                 recording(801, "usable"), recording(1e6, "usable"), Json{{"error", "none"}}});
  const Json found =
      decid::tools::groups_json(recordings, {"b", "a", "a", "b", "a", "a", "a", "b", "a", "b", "", "b"}, table);
  REQUIRE(found["groups"].size() == 2);
  CHECK(found["groups"][0]["name"] == "a");
  CHECK(found["groups"][0]["recordings"] == 5);
  CHECK(found["groups"][1]["recordings"] == 4);
  CHECK(near(found["groups"][0]["parameters"][3]["sd"].get<double>(), 63.37744078140107, 1e-14));
  REQUIRE(found["comparisons"].size() == 1);
  CHECK(found["comparisons"][0]["groups"] == Json{"a", "b"});
  const Json& last = found["comparisons"][0]["parameters"][6];
  CHECK(last["name"] == "delay");
  CHECK(near(last["difference"].get<double>(), 132.3, 1e-13));
  CHECK(near(last["hedges_g"].get<double>(), 1.870954512360277, 1e-13));
  CHECK(near(last["interval95"][1].get<double>(), 3.324537266855372, 1e-13));
  CHECK(recordings[0]["group"] == "b");
  CHECK_FALSE(recordings[10].contains("group"));
  const std::string text = decid::tools::groups_text(found);
  CHECK(text.find("a: 5 recordings\n    Kp              856.8 +- 63.4\n") != std::string::npos);
  CHECK(text.find("a less b") != std::string::npos);
  CHECK(text.find("    delay           132.3     1.87  0.42 to 3.32\n") != std::string::npos);
  CHECK(decid::tools::groups_text(nullptr).empty());
  CHECK(decid::tools::page_groups(found, recordings)["members"].size() == 11);
  CHECK(decid::tools::page_groups(nullptr, recordings).is_null());
}

TEST_CASE("a group of one has no effect size, and three groups have three comparisons") {
  const decid::sim::ParameterTable& table = decid::sim::single_pendulum().parameters;
  Json recordings = Json::array();
  for (int i = 0; i < 3; ++i) {
    recordings.push_back({{"file", "f"}, {"parameters", Json::array()}, {"trust", "usable"}});
    for (std::size_t p = 0; p < table.size(); ++p)
      recordings[recordings.size() - 1]["parameters"].push_back({{"value", i}});
  }
  const Json found = decid::tools::groups_json(recordings, {"a", "b", "c"}, table);
  REQUIRE(found["comparisons"].size() == 3);
  CHECK(found["comparisons"][2]["groups"] == Json{"b", "c"});
  CHECK(found["comparisons"][1]["parameters"][0]["difference"] == -2.0);
  CHECK(found["comparisons"][1]["parameters"][0]["hedges_g"].is_null());
  CHECK(found["groups"][0]["parameters"][0]["sd"].is_null());
  CHECK(decid::tools::groups_text(found).find("    Kp                 -1        -  - to -\n") != std::string::npos);
}
