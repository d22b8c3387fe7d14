// The page of tools/bench-report: results of tools/bench (Google Benchmark's JSON), oldest first, as trends, parts of
// the machine's peak and ratios to peers. tools/report/page.cpp makes the page, bench/report.js draws it.
//   bench_report PAGE.html RESULT.json...
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "embedded/bench_report_js.hpp"
#include "tools/report/page.hpp"

namespace {

using decid::Code;
using decid::Error;
using json = nlohmann::ordered_json;

struct Result {
  std::string name, date;
  json content;
};

Result read_result(const std::filesystem::path& path) {
  const auto refuse = [&](const std::string& what) -> Error {
    return {Code::file_unsupported, path.string(), what, "give results of tools/bench -o"};
  };
  json content = json::parse(decid::read_file(path), nullptr, false);
  if (!content.is_object() || !content.contains("context") || !content.contains("benchmarks") ||
      !content["context"].is_object() || !content["benchmarks"].is_array())
    throw refuse("is not a JSON object with Google Benchmark's context and benchmarks");
  for (const char* key : {"date", "machine", "compiler", "commit", "isa", "threads"})
    if (!content["context"].contains(key) || !content["context"][key].is_string())
      throw refuse(std::string("its context has no '") + key + "'");
  for (const json& entry : content["benchmarks"]) {
    if (!entry.contains("name") || !entry["name"].is_string() || !entry.contains("real_time") ||
        !entry["real_time"].is_number() || !entry.contains("time_unit") || !entry["time_unit"].is_string())
      throw refuse("a benchmark has no name, real_time or time_unit");
  }
  const std::string date = content["context"]["date"];
  return {path.stem().string(), date, std::move(content)};
}

/// Returns the name without the suffixes of Google Benchmark, which say how it is timed.
std::string short_name(const json& entry) {
  std::string name = entry["name"];
  const std::string tail = "/manual_time";
  if (name.ends_with(tail)) name.resize(name.size() - tail.size());
  return name;
}

double seconds_of(const json& entry, const std::string& where) {
  static const std::map<std::string, double> units{{"ns", 1e-9}, {"us", 1e-6}, {"ms", 1e-3}, {"s", 1.0}};
  const auto unit = units.find(entry["time_unit"].get<std::string>());
  if (unit == units.end())
    throw Error(Code::file_unsupported, where, "has an unknown time_unit", "Google Benchmark has ns, us, ms and s");
  return entry["real_time"].get<double>() * unit->second;
}

/// Peers of the context (bench/peers/compare), and those that benchmarks measured beside themselves.
json peers_of(const Result& result) {
  json peers = json::array();
  const json& context = result.content["context"];
  if (context.contains("peers"))
    for (const json& row : context["peers"])
      peers.push_back({{"what", row.at("what")}, {"unit", row.at("unit")}, {"ratio", row.at("ratio")}});
  for (const json& entry : result.content["benchmarks"]) {
    if (entry.contains("x plain"))
      peers.push_back({{"what", short_name(entry) + " beside a plain loop"},
                       {"unit", "times as fast"},
                       {"ratio", entry["x plain"]}});
    if (entry.contains("fftw/ours"))
      peers.push_back(
          {{"what", short_name(entry) + " beside FFTW"}, {"unit", "times as fast"}, {"ratio", entry["fftw/ours"]}});
  }
  return peers;
}

/// Returns one value per benchmark and run, null where a run has none.
json page_data(const std::vector<Result>& results) {
  json runs = json::array();
  std::map<std::string, std::size_t> places;
  json benchmarks = json::array();
  for (std::size_t run = 0; run < results.size(); ++run) {
    const Result& result = results[run];
    const json& context = result.content["context"];
    json about{{"name", result.name}, {"peers", peers_of(result)}};
    for (const char* key : {"date", "machine", "compiler", "commit", "isa", "threads"}) about[key] = context[key];
    runs.push_back(std::move(about));
    for (const json& entry : result.content["benchmarks"]) {
      const std::string name = short_name(entry);
      const auto [place, fresh] = places.emplace(name, benchmarks.size());
      if (fresh)
        benchmarks.push_back({{"name", name},
                              {"of", entry.contains("%bandwidth") ? "bandwidth" : "peak"},
                              {"percent", std::vector<json>(results.size())},
                              {"seconds", std::vector<json>(results.size())}});
      json& benchmark = benchmarks[place->second];
      benchmark["seconds"][run] = decid::tools::page_number(seconds_of(entry, result.name));
      for (const char* key : {"%peak", "%bandwidth"})
        if (entry.contains(key)) benchmark["percent"][run] = entry[key];
    }
  }
  return {{"runs", std::move(runs)}, {"benchmarks", std::move(benchmarks)}};
}

void write_page(const std::filesystem::path& page, const std::vector<std::filesystem::path>& files) {
  std::vector<Result> results;
  for (const auto& file : files) results.push_back(read_result(file));
  std::stable_sort(results.begin(), results.end(), [](const Result& a, const Result& b) { return a.date < b.date; });
  decid::write_file(page, decid::tools::page_html({.title = "Benchmarks",
                                                   .lead = "Time, part of the machine's peak, and ratios to peers, "
                                                           "from run to run.",
                                                   .script = decid::embedded::bench_report_js()},
                                                  page_data(results)));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fputs("usage: bench_report PAGE.html RESULT.json...\n", stderr);
    return 2;
  }
  try {
    write_page(argv[1], {argv + 2, argv + argc});
  } catch (const Error& error) {
    std::fprintf(stderr, "bench_report: %s\n", error.what());
    return 2;
  } catch (const nlohmann::json::exception& error) {
    std::fprintf(stderr, "bench_report: %s; give results of tools/bench -o\n", error.what());
    return 2;
  }
}
