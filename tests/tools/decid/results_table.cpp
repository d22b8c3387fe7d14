// The table of results: its form, and that it says what the JSON says.
#include "tools/decid/results/results_table.hpp"

#include <doctest/doctest.h>

#include "base/files/json_object.hpp"
#include "sim/body_model.hpp"

using decid::Json;
using decid::tools::results_table;

namespace {

const decid::sim::ParameterTable& parameters() {
  return decid::sim::single_pendulum().parameters;
}

Json recording(const std::string& file) {
  Json made{{"file", file}, {"parameters", Json::array()}, {"trust", "usable"}};
  for (std::size_t p = 0; p < parameters().size(); ++p) {
    const double value = 0.1 * static_cast<double>(p + 1);
    made["parameters"].push_back(
        {{"name", parameters()[p].name}, {"value", value}, {"interval90", {value / 3, 2 * value}}});
  }
  return made;
}

}  // namespace

TEST_CASE("table: a line a recording, figures to the bit") {
  const std::string table = results_table(Json::array({recording("a.csv")}), parameters());
  const std::size_t line = table.find('\n') + 1;
  CHECK(table.substr(0, line) ==
        "file,trust,Kp,Kp_low90,Kp_high90,Kd,Kd_low90,Kd_high90,Kp_pass,Kp_pass_low90,Kp_pass_high90,"
        "Kd_pass,Kd_pass_low90,Kd_pass_high90,Nv,Nv_low90,Nv_high90,theta,theta_low90,theta_high90,"
        "delay,delay_low90,delay_high90,error\n");
  CHECK(table.substr(line).starts_with("a.csv,usable,0.1,0.03333333333333333,0.2,0.2,"));
  CHECK(table.ends_with(",1.4000000000000001,\n"));
  CHECK(std::stod("0.03333333333333333") == 0.1 / 3);
}

TEST_CASE("table: every line has as many cells, whatever is missing") {
  Json point = recording("point.csv"), unknown = recording("unknown.csv");
  for (Json& parameter : point["parameters"]) parameter.erase("interval90");
  unknown["parameters"][6]["value"] = nullptr;
  const Json failed{{"file", "c,d.csv"}, {"error", "c,d.csv: no \"sway\"; name it"}};
  const std::string table = results_table(Json::array({point, unknown, failed}), parameters());
  CHECK(table.find("\npoint.csv,usable,0.1,,,0.2,,,") != std::string::npos);
  CHECK(table.find(",,0.2333333333333333") != std::string::npos);
  CHECK(table.ends_with("\n\"c,d.csv\",,,,,,,,,,,,,,,,,,,,,,,\"c,d.csv: no \"\"sway\"\"; name it\"\n"));
}

TEST_CASE("table: a name that is not UTF-8 leaves a table that is") {
  const std::string table = results_table(Json::array({Json{{"file", "a\xff.csv"}, {"error", "no"}}}), parameters());
  CHECK(table.find("\na\xEF\xBF\xBD.csv,") != std::string::npos);
}
