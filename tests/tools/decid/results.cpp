// Output for a made-up body with fourteen parameters: text and figures agree with the body's table.
#include "tools/decid/results/results.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/files/sha256.hpp"
#include "base/text.hpp"
#include "dataset/sets/dataset.hpp"
#include "tests/helpers.hpp"
#include "tests/near.hpp"
#include "tests/sim/made_up_body.hpp"
#include "tools/decid/results/calibrated_trials.hpp"
#include "tools/decid/results/table.hpp"
#include "tools/report/comparison_page.hpp"
#include "tools/report/dataset_page.hpp"
#include "tools/report/identify_page.hpp"
#include "tools/report/json/parameters_json.hpp"
#include "tools/report/json/posterior_results.hpp"

namespace decid::tools {
namespace {

using Json = nlohmann::ordered_json;

const sim::ParameterTable& table() {
  return test::made_up_body().parameters;
}

sim::Parameters values(std::uint64_t number) {
  return dataset::base_trial(table(), 17, number).parameters;
}

Report identified() {
  Report all;
  all.protocol = test::made_up_protocol();
  RecordingResult& id = all.recordings.emplace_back();
  id.file = "trial.csv";
  id.column = "com_sway_deg";
  id.truth = values(1);
  id.estimate.parameters = values(2);
  id.trial = recording::make_trial(std::vector<float>(400, 0.01F));
  all.tilt_rad.assign(400, 0.0F);
  return all;
}

void check_names(const Json& by_name) {
  REQUIRE(by_name.size() == 14);
  std::size_t p = 0;
  for (const auto& [name, unused] : by_name.items()) CHECK(name == table()[p++].name);
}

}  // namespace

TEST_CASE("fourteen parameters as results: JSON, text and page") {
  const Report all = identified();
  const Json recording = recordings_json(all).at(0);
  const Json& parameters = recording.at("parameters");
  REQUIRE(parameters.size() == 14);
  const std::string text = report_text(all), page = identify_page(all);
  for (std::size_t p = 0; p < 14; ++p) {
    const sim::ParameterInfo& info = table()[p];
    CHECK(parameters[p].at("name") == info.name);
    CHECK(parameters[p].at("unit") == info.unit);
    CHECK(parameters[p].at("value") == values(2)[p]);
    CHECK(parameters[p].at("true") == values(1)[p]);
    CHECK(parameters[p].at("normalized").is_null() != info.scales_with_mgh);
    CHECK_FALSE(parameters[p].contains("sd"));  // point estimates do not say how sure they are
    CHECK_FALSE(parameters[p].contains("interval90"));
    CHECK(text.find("(" + info.name + ")") != std::string::npos);
    CHECK(page.find("\"name\":\"" + info.name + "\"") != std::string::npos);
    CHECK(page.find("\"description\":\"" + info.description + "\"") != std::string::npos);
  }
  CHECK(text.find("Kp") == std::string::npos);
  CHECK(text.find("interval") == std::string::npos);
  CHECK_FALSE(recording.contains("correlations"));
  CHECK(page.find("\"densities\":") == std::string::npos);
}

TEST_CASE("gaps of a recording are in seconds of its own protocol") {
  Report all = identified();
  all.other_settings.emplace_back().protocol = all.protocol;
  all.other_settings[0].protocol.experiment.sample_rate_hz = 0.5 * all.protocol.experiment.sample_rate_hz;
  all.other_settings[0].tilt_rad = all.tilt_rad;
  all.recordings.push_back(all.recordings[0]);
  all.recordings[1].setting = 1;
  for (RecordingResult& id : all.recordings) id.trial.gaps = {{100, 200}};
  const Json recordings = recordings_json(all);
  const double rate_hz = all.protocol.experiment.sample_rate_hz;
  CHECK(recordings[0].at("gaps")[0] == Json{{"begin_s", 100.0 / rate_hz}, {"end_s", 200.0 / rate_hz}});
  CHECK(recordings[1].at("gaps")[0] == Json{{"begin_s", 200.0 / rate_hz}, {"end_s", 400.0 / rate_hz}});
}

TEST_CASE("fourteen parameters as a distribution: JSON, text and page") {
  Report all = identified();
  std::vector<double> outputs(mixture_outputs(1, 14), 0.0);
  for (std::size_t i = 0; i < 14; ++i) outputs[1 + i] = outputs[15 + i] = 0.1 * static_cast<double>(i);
  outputs[29] = 0.8;  // of the second and the first
  all.recordings[0].estimate.distribution.emplace(Mixture(1, 14, outputs), table());
  const ParameterDistribution& found = *all.recordings[0].estimate.distribution;
  const Json recording = recordings_json(all).at(0);
  const std::string text = report_text(all);
  const double mgh = all.protocol.experiment.body.mgh();
  REQUIRE(recording.at("correlations").size() == 14);
  CHECK(recording.at("correlations")[1][0] == found.correlation(1, 0));
  CHECK(recording.at("correlations")[1][0] < -0.5);
  CHECK(recording.at("correlations")[13][13] == 1.0);
  for (std::size_t p = 0; p < 14; ++p) {
    const int quantity = static_cast<int>(p);
    const Json& parameter = recording.at("parameters")[p];
    CHECK(parameter.at("value") == values(2)[p]);
    CHECK(parameter.at("sd") == found.stddev(quantity));
    CHECK(parameter.at("interval50") == Json{found.quantile(quantity, 0.25), found.quantile(quantity, 0.75)});
    const double low = found.quantile(quantity, 0.05), high = found.quantile(quantity, 0.95);
    CHECK(test::near(parameter.at("interval90")[0].get<double>(), low, 1e-14));
    CHECK(test::near(parameter.at("interval90")[1].get<double>(), high, 1e-14));
    if (table()[p].scales_with_mgh)
      CHECK(test::near(parameter.at("normalized_interval90")[1].get<double>(), high / mgh, 1e-14));
    else
      CHECK(parameter.at("normalized_interval90").is_null());
    CHECK(text.find(format("%.5g to %.5g", low, high)) != std::string::npos);
  }
  CHECK(text.find("90% interval") != std::string::npos);
  const std::string page = identify_page(all);
  CHECK(page.find("\"densities\":[[[0.0,") != std::string::npos);
}

TEST_CASE("fourteen parameters' errors, of a model and of methods") {
  Evaluation evaluation;
  evaluation.trials = 2;
  for (int p = 0; p < 14; ++p) evaluation.mse_per_parameter.push_back(0.5 + p);
  CHECK(evaluation.mse() == 7.0);
  CHECK(evaluation.matlab_loss() == 49.0);
  check_names(evaluation_json(table(), evaluation).at("mse_per_parameter"));

  ComparisonFigures figures;
  figures.protocol = test::made_up_protocol();
  const std::vector<sim::Parameters> truth{values(5), values(6)}, found{values(7), values(8)};
  sim::Parameters stddev(14);
  for (std::size_t p = 0; p < 14; ++p) stddev[p] = table()[p].range();
  figures.methods.push_back(compute_errors("network", "", found, truth, stddev));
  const Json json = comparison_json(figures);
  check_names(json.at("methods").at(0).at("mse_per_parameter"));
  double sum = 0.0;
  for (std::size_t p = 0; p < 14; ++p) {
    double of_parameter = 0.0;
    for (std::size_t i = 0; i < 2; ++i) of_parameter += std::pow((found[i][p] - truth[i][p]) / stddev[p], 2) / 2.0;
    CHECK(test::near(figures.methods[0].mse_per_parameter[p], of_parameter, 1e-14));
    sum += of_parameter;
  }
  CHECK(test::near(figures.methods[0].mse, sum / 14.0, 1e-14));
  const std::string text = comparison_text(figures);
  CHECK(text.find("| gain_13 | gain_14 | simulations | seconds |\n|") != std::string::npos);
  const std::size_t rule = text.find("\n|---|") + 1;
  CHECK(text.substr(rule, text.find('\n', rule) - rule).size() == 1 + 4 * 19);
}

TEST_CASE("fourteen parameters' distributions in a data set") {
  DatasetFigures figures;
  figures.request.protocol = test::made_up_protocol();
  figures.report.base = figures.report.all = dataset::TrialDistributions(table());
  for (std::uint64_t i = 0; i < 10; ++i) figures.report.all.add(values(i), 0.02);
  Json distributions = dataset_json(figures).at("distributions");
  CHECK(distributions.erase("peak_to_peak") == 1);
  check_names(distributions);
  CHECK(distributions.at("gain_14").at("description") == "Gain number 14");
  CHECK(distributions.at("gain_14").at("low") == table()[13].low);
}

TEST_CASE("the line of a fixed parameter has neither a standard deviation nor an interval") {
  struct Found {
    double low, high;
    double quantile(int, double part) const { return part < 0.5 ? low : high; }
    double stddev(int) const { return 0.3 * (high - low); }
  };
  const decid::sim::ParameterTable& parameters = decid::sim::single_pendulum().parameters;
  const auto line = [&](double low, double high) {
    return parameter_line(Found{low, high}, 0, parameters, 578.0, 839.0, {});
  };
  CHECK(decid::test::contains(line(578.0, 578.0), "fixed"));
  CHECK_FALSE(decid::test::contains(line(578.0, 578.0), "578 to 578"));
  CHECK(decid::test::contains(line(500.0, 600.0), "500 to 600"));
  CHECK_FALSE(decid::test::contains(line(500.0, 600.0), "fixed"));
}

TEST_CASE("the lines of warnings begin with the severity that the JSON has") {
  Warnings warnings;
  add_info(warnings, "rate_stated", "one");
  add_caution(warnings, "spikes", "two");
  add_caution(warnings, "jumps", "three");
  CHECK(trust_text(warnings) == "  caution: two\n");
  CHECK(warnings_text(warnings) == "  info: one\n  caution: three\n");
  add_invalid(warnings, "does_not_stand", "four");
  add_invalid(warnings, "impossible_value", "five");
  CHECK(trust_text(warnings) == "  not usable: four\n");
  CHECK(warnings_text(warnings) == "  info: one\n  caution: two\n  caution: three\n  invalid: five\n");
}

TEST_CASE("the text of controllers over several recordings: sums, differences, in how many each is best") {
  const std::string text =
      controller_sums_text({.recordings = 12,
                            .not_usable = 1,
                            .controllers = {{"dec2015", 3, -1234.56, -35.24, 12.06}, {"dec", 9, -1199.32, 0.0, 0.0}}});
  CHECK(test::contains(text, "over 12 recordings"));
  CHECK(test::contains(text, "  dec2015                     -1234.6              -35.2 +- 12.1        3\n"));
  CHECK(test::contains(text, "  dec                         -1199.3                       best        9\n"));
  CHECK(text.ends_with("  with 1 recording not usable\n"));
}

TEST_CASE("a table says what the values say: a line a recording, as many cells whatever is missing") {
  Report all = identified();
  RecordingResult unknown = all.recordings[0];
  unknown.file = "a\xff.csv";
  unknown.estimate.parameters[13] = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> outputs(mixture_outputs(1, 14), 0.0);
  unknown.estimate.distribution.emplace(Mixture(1, 14, outputs), table());
  RecordingResult failed;
  failed.file = "c,d.csv";
  failed.error = Error(Code::column_missing, "c,d.csv", "no \"sway\"", "name it");
  all.recordings.insert(all.recordings.end(), {unknown, failed});
  const std::string text = csv_text(wide_table(all), CsvStyle::plain);
  CHECK(text.starts_with("file,trust," + table()[0].name + "," + table()[0].name + "_low90,"));
  CHECK(text.find("\ntrial.csv,usable," + Json(values(2)[0]).dump() + ",,,") != std::string::npos);
  const double low = unknown.estimate.distribution->quantile(0, 0.5 * (1.0 - 0.9));
  CHECK(text.find("\na\xEF\xBF\xBD.csv,usable," + Json(values(2)[0]).dump() + "," + Json(low).dump() + ",") !=
        std::string::npos);
  CHECK(text.find("\n\"c,d.csv\",," + std::string(3 * 14, ',')) != std::string::npos);
  CHECK(text.ends_with(",\"c,d.csv: no \"\"sway\"\"; name it\"\n"));
  std::size_t begin = 0;
  const std::ptrdiff_t first_commas = std::ranges::count(text.substr(0, text.find('\n')), ',');
  for (int line = 0; line < 3; ++line) {
    const std::size_t end = text.find('\n', begin);
    CHECK(std::ranges::count(text.substr(begin, end - begin), ',') == first_commas);
    begin = end + 1;
  }
}

TEST_CASE("a table's copied columns of numbers are numbers where a spreadsheet reads texts otherwise") {
  const ResultTable table{.names = {"file", "id", "age", "mixed", "shift", "none"},
                          .rows = {{"a.csv", "007", "71.5", "1", "-0.25", Cell{}},
                                   {"2", "12", Cell{}, "1e3", "10", Cell{}},
                                   {"c.csv", "3", "0.5", "2", "0", Cell{}}},
                          .copied_begin = 1,
                          .copied_end = 6};
  const ResultTable found = with_numbers(table);
  CHECK(found.rows[1] == std::vector<Cell>{"2", "12", Cell{}, "1e3", 10.0, Cell{}});
  CHECK(found.rows[0] == std::vector<Cell>{"a.csv", "007", 71.5, "1", -0.25, Cell{}});
  CHECK(csv_text(table, CsvStyle::plain).find("\na.csv,007,71.5,1,-0.25,\n2,12,,1e3,10,\n") != std::string::npos);
  CHECK(csv_text(table, CsvStyle::excel_comma).find("\r\na.csv;007;71,5;1;-0,25;\r\n") != std::string::npos);
  CHECK(csv_text(table, CsvStyle::excel_point).find("\r\na.csv,007,71.5,1,-0.25,\r\n") != std::string::npos);
}

TEST_CASE("rows of calibrate's tables are read back as they were written, unknown values too") {
  const sim::ParameterTable& parameters = table();
  FitConditionFigures known, unknown;
  known.fault.name = "gap_s";
  known.fault.size = 2.0;
  known.trials = 3;
  known.usable = known.caution = known.not_usable = 1;
  known.codes = {{"at_edge", 1}, {"gaps_filled", 3}};
  known.mean_s = 4.5;
  Calibration& figures = known.figures.emplace();
  figures.trials = 3;
  figures.log_score = 1.5;
  figures.network_log_score = std::numeric_limits<double>::quiet_NaN();
  figures.all = {.mse = 0.1, .predicted_variance = 0.2, .network_mse = std::numeric_limits<double>::quiet_NaN()};
  figures.parameters.assign(parameters.size(), figures.all);
  figures.parameters[2].coverage90 = 0.25;
  known.usable_figures = figures;
  known.usable_figures->trials = 1;
  unknown.fault.name = "double_pendulum";
  const std::string written = rows_json({known, unknown}, parameters).dump();
  const std::vector<FitConditionFigures> read = rows_from_json(Json::parse(written), parameters);
  CHECK(rows_json(read, parameters).dump() == written);
  REQUIRE(read.size() == 2);
  CHECK(read[0].figures->parameters[2].coverage90 == 0.25);
  CHECK(std::isnan(read[0].figures->all.network_mse));
  CHECK(read[0].codes == known.codes);
  CHECK(read[0].usable_figures->trials == 1);
  CHECK(!read[1].figures);
  CHECK(!read[1].usable_figures);
  Json earlier = Json::parse(written);  // of a version without these figures
  earlier[0].erase("usable_figures");
  CHECK(!rows_from_json(earlier, parameters)[0].usable_figures);
}

}  // namespace decid::tools

TEST_CASE("the hash of a file of several pieces is its content's") {
  const decid::test::TemporaryFolder folder;
  for (const std::size_t bytes : {std::size_t{0}, std::size_t{1} << 20, (std::size_t{3} << 20) + 5}) {
    std::string content(bytes, 'a');
    if (bytes > 0) content.back() = 'b';
    CHECK(decid::tools::hash_file(decid::test::write_text(folder / "f", content).string()) == decid::sha256(content));
  }
  decid::test::check_error([&] { decid::tools::hash_file((folder / "none").string()); }, decid::Code::file_missing,
                           "none");
}
