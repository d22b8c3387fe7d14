// decid dataset as a process: killed and interrupted, it goes on to the same bytes; its figures, as JSON and as a page.
#include <fcntl.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <numeric>
#include <thread>

#include "base/files/sha256.hpp"
#include "dataset/npz/npz.hpp"
#include "tests/tools/decid/run.hpp"

using namespace decid::test;
using Json = nlohmann::json;

namespace {

/// 4 s: 0.1 ms a trial.
const char* const brief_protocol =
    R"({"sequence": {"feedback": [0, 0, -1, 1], "start": [0, 0, 0, 1], "state_s": 0.05, "amplitude_deg": 8,
        "offset_s": 0, "cycles": 1}})";

/// Starts the program with these arguments; its standard error goes to a file.
pid_t start(const std::vector<std::string>& arguments, const std::string& err) {
  std::vector<char*> argv;
  std::string program = DECID_PROGRAM;
  argv.push_back(program.data());
  std::vector<std::string> texts = arguments;
  for (std::string& text : texts) argv.push_back(text.data());
  argv.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    const int file = ::open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    ::dup2(file, STDERR_FILENO);
    ::execv(argv[0], argv.data());
    ::_exit(127);
  }
  return child;
}

/// Its status can still be waited for.
bool ended(pid_t child) {
  siginfo_t about{};
  return ::waitid(P_PID, static_cast<id_t>(child), &about, WEXITED | WNOHANG | WNOWAIT) != 0 || about.si_pid != 0;
}

}  // namespace

TEST_CASE("killed at any moment, the same command goes on to the same bytes") {
  const Folder folder;
  write_text(folder / "p.json", brief_protocol);
  const auto arguments = [&](const std::string& output) {
    return std::vector<std::string>{"dataset", "--count", "9000",       "--base",          "8000", "--threads",    "2",
                                    "--seed",  "7",       "--protocol", folder / "p.json", "-o",   folder / output};
  };
  const auto run = [&](const std::string& output) {
    std::string line;
    for (const std::string& argument : arguments(output)) line += argument + " ";
    return run_decid(line);
  };
  REQUIRE(run("whole.npz").code == 0);
  const std::string expected = decid::sha256(read_text(folder / "whole.npz"));
  const auto size_of = [&](const char* name) {
    std::error_code missing;
    const auto size = std::filesystem::file_size(folder / name, missing);
    return missing ? 0.0 : static_cast<double>(size);
  };
  const double whole = size_of("whole.npz");

  // Moments by what is written of the rest, in no order (golden ratio), as no two machines are equally fast; the file
  // in the end is one of several kills.
  int killed = 0, resumed = 0, in_this_file = 0;
  for (int i = 0; i < 10; ++i) {
    const double part = 0.05 + 0.75 * (0.618034 * i - static_cast<int>(0.618034 * i));
    const double begun = size_of("a.npz.partial");
    const pid_t child = start(arguments("a.npz"), folder / "err");
    while (size_of("a.npz.partial") < begun + part * (whole - begun) && !ended(child)) {
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
    ::kill(child, SIGKILL);
    int status = 0;
    REQUIRE(::waitpid(child, &status, 0) == child);
    killed += WIFSIGNALED(status);
    if (read_text(folder / "err").find("resuming at trial ") != std::string::npos) ++resumed;
    const bool finished = std::filesystem::exists(folder / "a.npz");
    if (!finished && ++in_this_file < 3) continue;
    const auto last = run("a.npz");
    CAPTURE(last.err);
    REQUIRE(last.code == 0);
    CHECK(decid::sha256(read_text(folder / "a.npz")) == expected);
    CHECK_FALSE(std::filesystem::exists(folder / "a.npz.partial"));
    CHECK_FALSE(std::filesystem::exists(folder / "a.npz.partial.journal"));
    std::filesystem::remove(folder / "a.npz");
    in_this_file = 0;
  }
  CHECK(killed >= 5);  // or this test would say nothing
  CHECK(resumed >= 2);
}

TEST_CASE("Ctrl-C keeps the trials until then, and the same command goes on") {
  const Folder folder;
  write_text(folder / "p.json", brief_protocol);
  const std::string command =
      "dataset --count 200000 --seed 7 --protocol " + folder / "p.json" + " -o " + folder / "a.npz";
  const std::string said = interrupted(command, "test -s " + folder / "a.npz.partial").err;
  CHECK(contains(said, "stopped at trial "));
  CHECK(contains(run_ok(command).err, "resuming at trial "));
  CHECK(folder.files() == 2);  // protocol, data set
}

TEST_CASE("the figures of a data set: one JSON object, a table, and a page") {
  const Folder folder;
  write_text(folder / "p.json", brief_protocol);
  const std::string command = "dataset --count 400 --base 300 --seed 7 --protocol " + folder / "p.json" + " -o " +
                              folder / "a.npz" + " --report " + folder / "a.html --json";
  const auto result = run_ok(command);
  const Json figures = Json::parse(result.out);
  const decid::dataset::Dataset data = decid::dataset::read_npz(folder / "a.npz");
  CHECK(figures.at("trials") == 400);
  CHECK(figures.at("base_trials") == 300);
  CHECK(figures.at("bytes") == std::filesystem::file_size(folder / "a.npz"));
  CHECK(figures.at("acceptance_rate") == 300.0 / figures.at("base_attempts").get<double>());
  CHECK(figures.at("child_acceptance_rate") == 100.0 / figures.at("child_attempts").get<double>());
  CHECK(figures.at("parent_threshold_rad") == 0.05);
  CHECK(figures.at("distributions").size() == 8);
  const auto mean = [&](int trials) {
    double sum = 0.0;
    for (int i = 0; i < trials; ++i) sum += data.parameters[static_cast<std::size_t>(i)][0];
    return sum / trials;
  };
  const Json& kp = figures.at("distributions").at("Kp");
  CHECK(kp.at("unit") == "N m/rad");
  // As many roundings on either side as there are trials.
  CHECK(near(kp.at("base").at("mean").get<double>(), mean(300), 300 * 0x1p-52));
  CHECK(near(kp.at("enriched").at("mean").get<double>(), mean(400), 400 * 0x1p-52));
  const Json& sway = figures.at("distributions").at("peak_to_peak");
  const auto counts = sway.at("enriched").at("counts").get<std::vector<int>>();
  CHECK(std::accumulate(counts.begin(), counts.end(), 0) == 400);
  const auto before = sway.at("base").at("counts").get<std::vector<int>>();
  CHECK(std::accumulate(before.begin() + 10, before.end(), 0) == figures.at("parents"));

  for (const auto& info : decid::sim::single_pendulum().parameters) CHECK(contains(result.err, info.name));

  const Json shown = page_data(folder / "a.html");
  CHECK(shown.at("distributions") == figures.at("distributions"));
  CHECK(shown.at("protocol").at("duration_s") == 4.0);

  CHECK(run_decid(command + " --quiet").err.empty());
  const auto base_only =
      run_decid("dataset --count 50 --seed 7 --json --protocol " + folder / "p.json" + " -o " + folder / "b.npz");
  CHECK(Json::parse(base_only.out).at("child_acceptance_rate").is_null());
}

TEST_CASE("a report that cannot be written is an error before the work") {
  const Folder folder;
  const std::string command = "dataset --count 10 -o " + folder / "a.npz" + " --report ";
  for (const std::string& report :
       {std::string("/nowhere/a.html"), folder / "a.npz", folder / "a.npz.partial", folder / "a.npz.partial.journal"}) {
    CAPTURE(report);
    const auto result = run_decid(command + report);
    CHECK(result.code == 2);
    CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
    CHECK(folder.files() == 0);
  }
}
