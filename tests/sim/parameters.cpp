// Sets of parameters and their tables: the single pendulum's, and a made-up body's fourteen.
#include "sim/parameters.hpp"

#include <cmath>
#include <limits>

#include "sim/double_pendulum.hpp"
#include "sim/simulate.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"
#include "tests/sim/made_up_body.hpp"

using namespace decid;
using namespace decid::sim;
using namespace decid::test;

namespace {

ParameterInfo named(const std::string& name) {
  return {
      .name = name, .option = name, .description = {}, .unit = "1", .low = 0.0, .high = 1.0, .scales_with_mgh = false};
}

}  // namespace

TEST_CASE("Parameters: equal in number and values") {
  Parameters a(3);
  a[1] = 2.5;
  CHECK(a == Parameters{0.0, 2.5, 0.0});
  for (const Parameters& other : {Parameters{0.0, 2.5}, {0.0, 2.5, 0.0, 0.0}, {0.0, 2.5, 1.0}}) CHECK(other != a);
}

TEST_CASE("ParameterTable: the single pendulum's") {
  const ParameterTable& table = single_pendulum().parameters;
  CHECK(table.names() == std::vector<std::string>{"Kp", "Kd", "Kp_pass", "Kd_pass", "Nv", "theta", "delay"});
  CHECK(table[Kp_pass].name == "Kp_pass");
  CHECK(table[Delay].name == "delay");
  CHECK(table[Kp].unit_after() == " N m/rad");
  CHECK(table[Nv].unit_after().empty());
  CHECK(table[Nv].shown_unit().empty());
  const Parameters middle = table.middle();
  for (std::size_t i = 0; i < table.size(); ++i) CHECK(middle[i] == 0.5 * (table[i].low + table[i].high));
  CHECK(&Protocol{}.parameters() == &table);

  Parameters outside = middle;
  outside[Nv] = -0.01;
  outside[Delay] = 1.5;
  outside[Kp] = 1e9;
  Parameters nearest = middle;
  nearest[Nv] = 0.0;
  nearest[Delay] = longest_delay_s;
  nearest[Kp] = 1e9;
  CHECK(table.simulable(outside) == nearest);
  CHECK(table.simulable(middle) == middle);
}

TEST_CASE("ParameterInfo: beyond its range is beyond a twentieth of it") {
  ParameterInfo info = single_pendulum().parameters[Kp];
  info.low = 20.0;
  info.high = 40.0;
  for (const double inside : {19.0, 20.0, 40.0, 41.0}) CHECK(!info.is_beyond(inside));
  for (const double outside : {18.9, 41.1, std::nan("")}) CHECK(info.is_beyond(outside));
}

TEST_CASE("ParameterTable: to the unit box and back") {
  for (const ParameterTable* table : {&single_pendulum().parameters, &made_up_body().parameters}) {
    std::vector<double> unit;
    for (std::size_t i = 0; i < table->size(); ++i) unit.push_back(0.1 + 0.05 * static_cast<double>(i));
    unit[0] = -0.25;  // neither way has bounds
    unit[1] = 1.5;
    const Parameters values = table->from_unit(unit);
    REQUIRE(values.size() == table->size());
    CHECK(values[0] < (*table)[0].low);
    CHECK(values[1] > (*table)[1].high);
    const std::vector<double> back = table->to_unit(values);
    for (std::size_t i = 0; i < unit.size(); ++i) CHECK(within(back[i], unit[i], 1e-14));
    for (const double half : table->to_unit(table->middle())) CHECK(near(half, 0.5, 1e-14));
  }
}

TEST_CASE("ParameterTable: values as text, in any order and by either name") {
  const ParameterTable& seven = single_pendulum().parameters;
  CHECK(seven.from_text("delay=0.1,kp=900,Kd=250,kp-pass=220,Kd_pass=125,nv=0.4,theta=0.0026", "text") ==
        Parameters{900, 250, 220, 125, 0.4, 0.0026, 0.1});
  check_error([&] { seven.from_text("Kp=900", "--truth"); }, Code::setting_malformed, "Kp_pass");
  const ParameterTable& fourteen = made_up_body().parameters;
  std::string text;
  for (std::size_t i = 14; i-- > 0;) text += fourteen[i].option + "=" + std::to_string(i + 1) + (i > 0 ? "," : "");
  const Parameters read = fourteen.from_text(text, "text");
  for (std::size_t i = 0; i < 14; ++i) CHECK(read[i] == static_cast<double>(i + 1));
  check_error([&] { fourteen.from_text("gain_1=1", "text"); }, Code::setting_malformed, "gain_1");
  check_error([&] { fourteen.from_text("Kp=900", "text"); }, Code::setting_malformed, "'Kp'");
  check_error([&] { fourteen.from_text("gain_1=1,gain-1=2", "text"); }, Code::setting_malformed, "-1 twice");
  check_error([&] { fourteen.from_text("gain_1", "text"); }, Code::setting_malformed, "'gain_1'");
  check_error([&] { fourteen.from_text("gain_1=nan", "text"); }, Code::setting_malformed, "'nan'");
}

TEST_CASE("ParameterTable: tables that are none") {
  const auto table = [](std::vector<ParameterInfo> all) { return [all] { ParameterTable{all}; }; };
  check_error(table({}), Code::setting_out_of_range, "a table has 0");
  check_error(table(std::vector<ParameterInfo>(Parameters::max_parameters + 1, named("a"))), Code::setting_out_of_range,
              "33");
  std::vector<ParameterInfo> full;
  while (full.size() < Parameters::max_parameters) full.push_back(named("p" + std::to_string(full.size())));
  CHECK(ParameterTable(full).names().size() == Parameters::max_parameters);
  check_error(table({named("a"), named("b"), named("a")}), Code::setting_conflict);
  ParameterInfo also_a = named("b");
  also_a.option = "a";
  check_error(table({named("a"), also_a}), Code::setting_conflict);
  for (const auto& [low, high] : {std::pair(1.0, 1.0),
                                  {2.0, 1.0},
                                  {-0.5, 1.0},
                                  {0.0, std::nan("")},
                                  {0.0, std::numeric_limits<double>::infinity()}}) {
    ParameterInfo bad = named("a");
    bad.low = low;
    bad.high = high;
    bad.max = 100.0;
    check_error(table({bad}), Code::setting_out_of_range);
  }
}

TEST_CASE("a body model that no simulator knows is refused by name, and makes another experiment") {
  CHECK(made_up_protocol().experiment != tiny_protocol().experiment);
  CHECK_NOTHROW(made_up_protocol().validate());
  check_error([] { Simulator{made_up_protocol()}; }, Code::not_supported);
  check_error([] { DoubleSimulator{made_up_protocol()}; }, Code::not_supported);
  const Simulator simulator(tiny_protocol());
  std::vector<double> sway(static_cast<std::size_t>(simulator.samples()));
  check_error([&] { simulator.run(Parameters(14), Random(1, sim::streams::vestibular_noise, 0), sway); },
              Code::size_mismatch, "14 values");
}
