// Figures of results: which there are, their numbers as CSV, and where the drawing puts them.
#include "tools/report/figures/result_figures.hpp"

#include <doctest/doctest.h>

#include <numbers>
#include <sstream>

#include "base/files/json_object.hpp"
#include "sim/body_model.hpp"
#include "tests/helpers.hpp"
#include "tests/tools/report/page_text.hpp"

namespace decid::tools {
namespace {

/// Adds a recording whose Kp is `kp`, with a response of this gain at two frequencies.
void add(Report& report, const SheetEntry& who, double kp, double gain) {
  RecordingResult& made = report.recordings.emplace_back();
  made.file = who.participant + who.session + ".csv";
  made.entry = who;
  made.estimate.parameters = sim::single_pendulum().parameters.middle();
  made.estimate.parameters[0] = kp;
  FrequencyResponses& frf = made.explanation.frf.emplace();
  for (const double hz : {0.1, 1.0}) {
    sim::FrfPoint& point = frf.recorded.emplace_back();
    point.frequency_hz = hz;
    point.response = {0.0, -gain};
    frf.linear.emplace_back(0.0, -1.0);
  }
}

/// Two groups of two people; one person has two sessions.
Report study() {
  Report report;
  add(report, {"P1", "1", "patients", ""}, 600.0, 1.0);
  add(report, {"P1", "2", "patients", ""}, 700.0, 2.0);
  add(report, {"P2", "1", "patients", ""}, 800.0, 3.0);
  add(report, {"K, 1", "1", "controls", ""}, 900.0, 4.0);
  add(report, {"K2", "1", "controls", ""}, 1000.0, 5.0);
  return report;
}

std::vector<std::string> ids(const std::vector<Figure>& figures) {
  std::vector<std::string> all;
  for (const Figure& figure : figures) all.push_back(figure.id);
  return all;
}

std::vector<std::string> lines_with(const std::string& csv, const std::string& part) {
  std::vector<std::string> found;
  std::istringstream text(csv);
  for (std::string line; std::getline(text, line);)
    if (line.find(part) != std::string::npos) found.push_back(line);
  return found;
}

}  // namespace

TEST_CASE("figures of results: groups, sessions and responses, each with its numbers") {
  const std::vector<Figure> figures = result_figures(study());
  REQUIRE(ids(figures) == std::vector<std::string>{"estimates", "sessions", "responses"});
  for (const Figure& figure : figures) {
    CHECK(figure.svg.starts_with("<svg "));
    CHECK(figure.svg.ends_with("</svg>\n"));
    CHECK(figure.svg.find("nan") == std::string::npos);
  }
  const std::string mgh = Json(Report{}.protocol.experiment.body.mgh()).dump();
  const std::vector<std::string> kp = lines_with(figures[0].csv, "Kp,");
  REQUIRE(kp.size() == 5);
  CHECK(kp[1] == "Kp,N m/rad,P1,2,patients,,P12.csv,700.0,,," + mgh);
  CHECK(kp[3] == "Kp,N m/rad,\"K, 1\",1,controls,,\"K, 11.csv\",900.0,,," + mgh);
  CHECK(test::count(figures[0].svg, "<circle") == 5 * 7);
  // Both groups' means: people count once, so the patients' is (650 + 800) / 2.
  CHECK(test::count(figures[0].svg, "stroke=\"#1c2733\"") == 2 * 7);

  const std::vector<std::string> change = lines_with(figures[1].csv, "Kp,");
  REQUIRE(change.size() == 5);
  CHECK(change[1] == "Kp,N m/rad,P1,patients,2,700.0," + mgh);
  CHECK(lines_with(figures[1].csv, "delay,")[1].ends_with(","));  // it does not scale with m g h
  CHECK(figures[1].csv.starts_with("parameter,unit,participant_id,group,session,value,mgh\n"));

  const std::vector<std::string> response = lines_with(figures[2].csv, "K2,");
  REQUIRE(response.size() == 2);
  CHECK(response[0] == "K2,1,controls,,K21.csv,0.1,5.0,-90.0");
}

TEST_CASE("figures of results: the mean of a group is of its people, not of its recordings") {
  Report one, two;
  add(one, {"A", "", "", ""}, 600.0, 1.0);
  add(one, {"A", "", "", ""}, 600.0, 1.0);
  add(one, {"A", "", "", ""}, 600.0, 1.0);
  add(one, {"B", "", "", ""}, 1000.0, 1.0);
  add(two, {"A", "", "", ""}, 600.0, 1.0);
  add(two, {"B", "", "", ""}, 1000.0, 1.0);
  const auto mean_line = [](const Report& report) {
    const std::string svg = result_figures(report).at(0).svg;
    const std::size_t at = svg.find("stroke=\"#1c2733\""), begin = svg.rfind("<path", at);
    return svg.substr(begin, at - begin);
  };
  CHECK(mean_line(one) == mean_line(two));
}

TEST_CASE("figures of results: stiffness and damping are those of the comparison's body, and the captions say so") {
  Report report = study();
  GroupReport& groups = report.groups.emplace();
  groups.table.members.resize(report.recordings.size());
  groups.mgh_nm_rad = 2.0 * report.protocol.experiment.body.mgh();
  groups.bodies_differ = true;
  const std::vector<Figure> figures = result_figures(report), own = result_figures(study());
  CHECK(lines_with(figures[0].csv, "Kp,")[1] ==
        "Kp,N m/rad,P1,2,patients,,P12.csv,1400.0,,," + Json(groups.mgh_nm_rad).dump());
  CHECK(test::count(figures[0].svg, ", for m g h 1") == 4);  // Kp, Kd, Kp_pass and Kd_pass
  CHECK(figures[1].csv.find(Json(groups.mgh_nm_rad).dump()) != std::string::npos);
  CHECK(lines_with(figures[0].csv, "delay,") == lines_with(own[0].csv, "delay,"));
  CHECK(figures[0].caption != own[0].caption);
  CHECK(figures[1].caption != own[1].caption);
  CHECK(figures[2].caption == own[2].caption);  // responses are not scaled
}

TEST_CASE("figures of results: a fixed parameter is no estimate") {
  Report report = study();
  report.fit.emplace().priors.parameters = {{.name = "Kp", .fixed = 839.0}};
  const std::vector<Figure> figures = result_figures(report), own = result_figures(study());
  REQUIRE(ids(figures) == ids(own));
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(lines_with(figures[i].csv, "Kp,").empty());
    CHECK(lines_with(figures[i].csv, "delay,") == lines_with(own[i].csv, "delay,"));
  }
  CHECK(test::count(figures[0].svg, "<circle") == 5 * 6);
  report.fit->priors.parameters.clear();
  for (const std::string& name : report.protocol.parameters().names())
    report.fit->priors.parameters.push_back({.name = name, .fixed = 0.1});
  CHECK(ids(result_figures(report)) == std::vector<std::string>{"responses"});
}

TEST_CASE("figures of results: recordings that cannot be used are left out; none make no figure") {
  Report report = study();
  report.recordings[0].error = Error(Code::file_missing, "P11.csv", "cannot be opened", "correct the name");
  add_invalid(report.recordings[3].warnings, "out_of_distribution", "it is unlike the training");
  report.recordings[4].explanation.frf.reset();
  const std::vector<Figure> figures = result_figures(report);
  REQUIRE(ids(figures) == std::vector<std::string>{"estimates", "sessions", "responses"});
  CHECK(lines_with(figures[0].csv, "Kp,").size() == 3);
  CHECK(lines_with(figures[2].csv, "controls").empty());
  report.recordings.resize(1);
  CHECK(result_figures(report).empty());
  CHECK(result_figures({}).empty());
}

TEST_CASE("figures of results: the responses of several controllers, of recordings that are not usable too") {
  Report report = study();
  for (RecordingResult& recording : report.recordings) {
    FitFigures& fit = recording.fit.emplace();
    fit.answer = FitFigures::Answer::network;  // there are no draws
    CheckedResponses& responses = fit.check.responses;
    responses.recorded = recording.explanation.frf->recorded;
    responses.gain = {{0.5, 0.6}, {0.75, 1.0}, {1.5, 1.25}};
    const double turn = 2.0 * std::numbers::pi, quarter = 0.25 * turn;
    responses.phase_rad = {{0.9 * turn - quarter, quarter}, {turn - quarter, 1.25 * quarter}, {turn, 1.5 * quarter}};
    fit.others.resize(1);
    fit.others[0].controller = "ic";
    fit.others[0].check = fit.check;
  }
  CHECK(ids(result_figures(report)).back() == "responses");  // none is compared
  report.recordings[4].fit->compared.emplace();
  const Figure one = result_figures(report).back();
  CHECK(one.id == "controllers");
  std::vector<std::string> lines = lines_with(one.csv, "K2,");
  REQUIRE(lines.size() == 4);
  // The simulated phases are a whole turn lower: within 180 degrees of the recorded one.
  CHECK(lines[0] == "K2,1,controls,,K21.csv,dec,0.1,5.0,-90.0,0.75,0.5,1.5,-90.0,-126.0,0.0");
  CHECK(lines[1] == "K2,1,controls,,K21.csv,dec,1.0,5.0,-90.0,1.0,0.6,1.25,-247.5,-270.0,-225.0");
  CHECK(lines[3].starts_with("K2,1,controls,,K21.csv,ic,1.0,5.0,-90.0,1.0,0.6,1.25,"));
  CHECK(test::count(one.svg, "fill-opacity") == 2 * 2);
  CHECK(test::count(one.svg, "<circle") == 2 * 2 * 2);
  CHECK(one.svg.find("nan") == std::string::npos);
  // The controller that predicts best shows how many turns the recorded phase has made.
  ControllerFit& other = report.recordings[4].fit->others[0];
  other.check.responses.phase_rad.middle = {-170.0 * sim::rad_per_deg, -285.0 * sim::rad_per_deg};
  const auto second_of_dec = [&] { return lines_with(result_figures(report).back().csv, "K2,")[1]; };
  CHECK(second_of_dec().starts_with("K2,1,controls,,K21.csv,dec,1.0,5.0,-450.0,"));
  other.compared.difference = -1.0;
  CHECK(second_of_dec().starts_with("K2,1,controls,,K21.csv,dec,1.0,5.0,-90.0,"));

  for (RecordingResult& recording : report.recordings) {
    recording.fit->compared.emplace();
    add_invalid(recording.warnings, "at_edge", "at the edge");
  }
  const std::vector<Figure> figures = result_figures(report);
  REQUIRE(ids(figures) == std::vector<std::string>{"controllers"});
  CHECK(lines_with(figures[0].csv, ",dec,").size() == 5 * 2);
  CHECK(test::count(figures[0].svg, "fill-opacity") == 5 * 2 * 2);
}

TEST_CASE("figures of results: groups and people of a table of groups") {
  Report report = study();
  for (RecordingResult& id : report.recordings) id.entry = {};
  report.groups.emplace();
  for (const char* group : {"a", "a", "b", "b", "b"}) report.groups->table.members.push_back({group, "someone"});
  const std::vector<Figure> figures = result_figures(report);
  REQUIRE(ids(figures) == std::vector<std::string>{"estimates", "responses"});
  CHECK(lines_with(figures[0].csv, ",someone,,b,").size() == 3 * 7);
}

}  // namespace decid::tools
