// The command line as users and scripts rely on it: what each command writes, and that it is what it should be.

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iostream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "base/text.hpp"
#include "sim/protocol/protocol.hpp"
#include "tests/tools/decid/run.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/ranks.hpp"

using namespace decid::test;
using Json = nlohmann::json;

TEST_CASE("the version of the program") {
  CHECK(run_decid("--version").out == std::string("decid ") + DECID_VERSION + "\n");
}

TEST_CASE("a weight or a height in another unit is refused with the value to give, one in no unit without") {
  const auto message_of = [](const std::string& option, const std::string& value) {
    const decid::tools::Program program("decid", "", "");
    decid::tools::add_identify(program.top());
    std::vector<std::string> words{"decid", "identify", "x.csv", option, value};
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    try {
      program.parse(static_cast<int>(arguments.size()), arguments.data());
    } catch (const decid::tools::UsageError& error) {
      return error.message;
    }
    return std::string("accepted");
  };
  struct Call {
    const char *option, *value, *advised;
  };
  for (const auto& [option, value, advised] :
       {Call{"--height", "175", "in cm, give 1.75"}, Call{"--height", "1625", "in mm, give 1.625"},
        Call{"--height", "69", "in inches, give 1.753"}, Call{"--com-height", "93", "in cm, give 0.93"},
        Call{"--mass", "300", "in lb, give 136.1"}, Call{"--mass", "70000", "in g, give 70"}})
    CHECK(message_of(option, value).ends_with(advised));
  for (const auto& [option, value] :
       {std::pair("--height", "12"), std::pair("--height", "tall"), std::pair("--mass", "0")}) {
    const std::string message = message_of(option, value);
    CHECK(contains(message, "is not from"));
    CHECK_FALSE(contains(message, "give"));
  }
}

namespace {

/// Writes this process's standard output to a file for its lifetime.
class StandardOutput {
 public:
  explicit StandardOutput(const std::string& path) : before_(::dup(STDOUT_FILENO)) {
    std::cout.flush();
    const int file = ::open(path.c_str(), O_CREAT | O_RDWR, 0600);
    REQUIRE((before_ >= 0 && file >= 0 && ::dup2(file, STDOUT_FILENO) >= 0));
    ::close(file);
  }
  StandardOutput(const StandardOutput&) = delete;
  StandardOutput& operator=(const StandardOutput&) = delete;
  ~StandardOutput() {
    ::dup2(before_, STDOUT_FILENO);
    ::close(before_);
  }

 private:
  int before_;
};

}  // namespace

TEST_CASE("an option that is given twice is refused with how often") {
  check_refused("simulate --seed 1 --seed 2 --seed 3", "--seed: is given 3 times");
}

TEST_CASE("a command that writes to the standard output leaves it to the next command of the process") {
  const Folder folder;
  const decid::tools::Program program("decid", "", "");
  decid::tools::add_stimulus(program.top());
  std::string words[] = {"decid", "stimulus", "--quiet", "--write-protocol", "/dev/stdout"};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  std::streambuf* const before = std::cout.rdbuf();
  {
    const StandardOutput redirected(folder / "out");
    program.parse(static_cast<int>(arguments.size()), arguments.data());
  }
  std::streambuf* const after = std::cout.rdbuf(before);  // so that a failure is printed
  CHECK(after == before);
  CHECK(Json::parse(read_text(folder / "out")).is_object());
}

TEST_CASE("Silenced: discards a stream's output for its lifetime, also within another one") {
  std::ostringstream stream;
  {
    const decid::tools::Silenced silenced(stream);
    stream << "a";
    { const decid::tools::Silenced again(stream); }
    stream << "b";
  }
  stream << "c";
  CHECK(stream.str() == "c");
}

#ifndef DECID_MPI
TEST_CASE("output_options: every option that names an output, which need not be alike on all hosts") {
  const decid::tools::Program program("decid", "", "");
  decid::tools::add_fit(program.top());
  const std::vector<std::string> outputs = decid::tools::output_options();
  for (const char* name : {"-o", "--output", "--report", "--table", "--long", "--draws", "--figures"}) {
    CAPTURE(name);
    CHECK(std::ranges::count(outputs, name) == 1);
  }
  CHECK(std::ranges::count(outputs, "--group") == 0);
}

TEST_CASE("several processes are refused by a program that is built without MPI") {
  const auto started = run_decid("info", "OMPI_COMM_WORLD_SIZE=2 ");
  CHECK(started.code == 2);
  CHECK(contains(started.err, "started 2 times by mpirun or srun, and is built without MPI"));
  run_ok("info", "OMPI_COMM_WORLD_SIZE=1 ");
}
#endif

TEST_CASE("simulate writes a trial that its seed determines") {
  const Folder folder;
  const auto first = run_ok("simulate --kp 900 --seed 7 --threads 1 -o " + folder / "a.csv");
  CHECK(first.out.empty());
  run_ok("simulate --kp 900 --seed 7 -o " + folder / "b.csv");
  CHECK(run_decid("simulate --kp 900 --seed 8 --quiet -o " + folder / "c.csv").err.empty());
  CHECK(read_text(folder / "a.csv") == read_text(folder / "b.csv"));
  CHECK(read_text(folder / "a.csv") != read_text(folder / "c.csv"));
  for (const char* seed : {"7", "8"}) run_ok(std::string("simulate --nv 0 --seed ") + seed + " -o " + folder / seed);
  CHECK(read_text(folder / "7") == read_text(folder / "8"));  // without noise every seed's trial is the same

  std::string header;
  const auto rows = read_csv(folder / "a.csv", header);
  CHECK(header == "time,com_sway_deg,tilt_deg");
  REQUIRE(rows.size() == 12100);
  double low = 0, high = 0;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    CHECK(near(rows[k][0], 0.01 * static_cast<double>(k), 1e-15));  // its few digits are written in full
    CHECK(std::abs(rows[k][1]) <= 5.0);
    low = std::min(low, rows[k][2]);
    high = std::max(high, rows[k][2]);
  }
  CHECK(rows[0][1] == 0.0);
  CHECK(near(high - low, 1.0, 5e-10));  // 10 digits of each
}

TEST_CASE("stimulus writes the tilt that simulate plays") {
  const Folder folder;
  run_ok("stimulus -o " + folder / "stim.csv");
  run_ok("simulate -o " + folder / "trial.csv");
  std::string header;
  const auto stimulus = read_csv(folder / "stim.csv", header);
  CHECK(header == "time,tilt_deg");
  const auto trial = read_csv(folder / "trial.csv", header);
  REQUIRE(stimulus.size() == trial.size());
  for (std::size_t k = 0; k < trial.size(); ++k) CHECK(stimulus[k][1] == trial[k][2]);
}

TEST_CASE("export sway reads recordings as identify does") {
  const Folder folder;
  run_ok("simulate -o " + folder / "t.csv");
  // The same options as identify's: a recording in radians under another name, inverted, is the same one.
  std::string header, text = "leaning,COM_y\n";
  for (const auto& row : read_csv(folder / "t.csv", header))
    text += decid::format("%.17g,0\n", -row[1] * decid::sim::rad_per_deg);
  write_text(folder / "u.csv", text);
  run_ok("export sway " + folder / "t.csv" + " -o " + folder / "t.bin");
  run_ok("export sway --column leaning --unit rad --rate 100 --invert sway " + folder / "u.csv" + " -o " +
         folder / "u.bin");
  CHECK(read_text(folder / "t.bin") == read_text(folder / "u.bin"));
  // Each recording of a file.
  std::string several = "number,sway_deg\n";
  for (const char* number : {"1", "2"})
    for (const auto& row : read_csv(folder / "t.csv", header)) several += decid::format("%s,%.17g\n", number, row[1]);
  write_text(folder / "several.csv", several);
  run_ok("export sway --rate 100 --trial number " + folder / "several.csv" + " -o " + folder / "two.bin");
  const std::string one = read_text(folder / "t.bin");
  CHECK(read_text(folder / "two.bin") == one + one);
}

TEST_CASE("export controller is for the result's body, and has 0 where a forced value is below 0") {
  const Folder folder;
  run_ok("simulate --quiet -o " + folder / "t.csv");
  run_ok("identify --quiet --mass 50 --height 1.6 " + folder / "t.csv " + folder / "t.csv" + " -o " +
         folder / "r.json");
  Json result = read_json(folder / "r.json");
  result["recordings"][1]["parameters"][decid::sim::Kp_pass]["value"] = -342.0;
  write_text(folder / "r.json", result.dump());
  const auto exported = run_ok("export controller --recording 2 --force " + folder / "r.json" + " -o " + folder / "c");
  CHECK(contains(exported.err, "Kp_pass = -342 is below 0: the controller has 0"));
  const std::string files = read_text(folder / "c/decid_controller.h") + read_text(folder / "c/decid_controller.c");
  CHECK(contains(files, decid::format("%.17g", result.at("body").at("inertia_kgm2").get<double>())));
  CHECK_FALSE(contains(files, "101.895"));
}

TEST_CASE("data set, training, evaluation and identification of a protocol of one's own") {
  const Folder folder;
  const std::string protocol = " --protocol " + quick_protocol(folder);
  run_ok("dataset --count 160 --seed 5" + protocol + " -o " + folder / "data.npz");
  const auto trained = run_ok("train --preset small --epochs 3 --json --quiet --data " + folder / "data.npz" + " -o " +
                              folder / "m.safetensors");
  CHECK(trained.err.empty());
  const Json summary = Json::parse(trained.out);
  CHECK(summary.at("weights_sha256").get<std::string>().size() == 64);
  const std::string log = read_text(folder / "m.safetensors.log.csv");
  CHECK(std::count(log.begin(), log.end(), '\n') == 4);
  CHECK_FALSE(std::filesystem::exists(folder / "m.safetensors.checkpoint"));

  const std::string model = " --model " + folder / "m.safetensors";
  const Json evaluation = run_json("evaluate --json --split validation" + model + " --data " + folder / "data.npz");
  CHECK(evaluation.at("trials") == 80);
  CHECK(evaluation.at("mse") == summary.at("validation_mse"));
  CHECK(near(evaluation.at("matlab_loss").get<double>(), 3.5 * evaluation.at("mse").get<double>(), 1e-15));
  CHECK(evaluation.at("mse_per_parameter").size() == 7);
  // evaluate never measures a model on its training trials: without --split it takes the other half, and says so.
  const auto own = run_decid("evaluate --json" + model + " --data " + folder / "data.npz");
  CHECK(without_call(Json::parse(own.out)) == without_call(evaluation));
  CHECK(contains(own.err, "was trained on"));

  const Json info = run_json("info --json " + folder / "m.safetensors");
  CHECK(info.at("weights_sha256") == summary.at("weights_sha256"));
  CHECK(info.at("protocol").at("name") == "quick");

  run_ok("simulate" + protocol + " -o " + folder / "trial.csv");
  run_ok("identify" + model + " " + folder / "trial.csv");
  const auto other = run_decid("evaluate --data " + folder / "data.npz");  // the built-in model knows another protocol
  CHECK(other.code == 2);
  CHECK(contains(other.err, "another experiment"));
}

TEST_CASE("evaluate: several models in one table, each as alone") {
  const Folder folder;
  run_ok("dataset --quiet --count 12 --seed 99 -o " + folder / "d.npz");
  const std::string data = " --data " + folder / "d.npz";
  const auto model = [](const std::string& name) {
    return " --model " DECID_SOURCE_DIR "/models/" + name + ".safetensors";
  };
  Json alone = run_json("evaluate --json" + model("built_in") + data);
  const Json other = run_json("evaluate --json" + model("spectra") + data);
  const Json both = run_json("evaluate --json" + model("built_in") + model("spectra") + data);
  REQUIRE(alone.at("models").size() == 1);
  REQUIRE(both.at("models").size() == 2);
  CHECK(both.at("models")[0] == alone.at("models")[0]);
  CHECK(both.at("models")[1] == other.at("models")[0]);
  CHECK(alone.at("command") == "evaluate");
  CHECK(alone.at("seed").is_null());
  CHECK(alone.at("inputs").size() == 2);
  CHECK(alone.at("inputs")[1].at("file") == folder / "d.npz");
  alone = without_call(alone);
  Json inner = alone.at("models")[0];
  inner.erase("model");
  alone.erase("models");
  CHECK(inner == alone);
  const std::string table = run_decid("evaluate" + model("built_in") + model("spectra") + data).out;
  for (const Json& line : both.at("models"))
    for (const Json& mse : line.at("mse_per_parameter"))
      CHECK(contains(table, decid::format(" %8.4f", mse.get<double>())));
  // The call computes the same again, without reading other trials.
  write_text(folder / "e.json", run_ok("evaluate --json --int8" + model("spectra") + data).out);
  run_ok("rerun " + folder / "e.json");
  run_ok("dataset --quiet --count 12 --seed 98 -o " + folder / "d.npz");
  check_refused("rerun " + folder / "e.json", "d.npz");
  // Each has to know the trials.
  run_ok("dataset --quiet --count 12 --seed 99 --protocol short -o " + folder / "s.npz");
  check_refused("evaluate" + model("spectra") + model("built_in") + " --data " + folder / "s.npz");
}

TEST_CASE("a model for bodies of many heights: trained, identified with, evaluated and studied") {
  const Folder folder;
  const std::string stimulus = R"("sequence": {"feedback": [0, 0, -1, 1], "start": [0, 0, 0, 1], "offset_s": 0})";
  const auto protocol = [&](const std::string& name, const std::string& more) {
    write_text(folder / name, "{" + stimulus + more + "}");
    return " --protocol " + folder / name;
  };
  const std::string many =
      protocol("many.json", R"(, "body_heights": [0.8, 1.12], "recording": {"gain": {"size": 0.1}})");
  write_text(folder / "image.json", R"({"block": 20, "channels": ["sway", "sway_change", "tilt", "height"]})");
  write_text(folder / "network.txt", "conv 4 7x1 stride 4x1\nrelu\nstatspool\nfc 7\n");
  run_ok("train --stream --quiet --stream-trials 128 --validation-trials 16 --epochs 1 --batch 32" + many +
         " --image " + folder / "image.json" + " --architecture " + folder / "network.txt" + " -o " +
         folder / "m.safetensors");
  const std::string model = " --model " + folder / "m.safetensors";
  run_ok("simulate" + many + " -o " + folder / "trial.csv");
  const std::string identify = "identify --json " + folder / "trial.csv" + model;
  const Json small = run_json(identify + " --mass 60 --height 1.5");
  const Json tall = run_json(identify + " --mass 60 --height 1.9");
  CHECK(small.at("body").at("assumed") == false);
  const auto over_mgh = [](const Json& result) {
    return result.at("recordings")[0].at("parameters")[0].at("normalized");
  };
  CHECK(over_mgh(small) != over_mgh(tall));
  check_refused(identify + " --mass 60 --height 1.3", "m.safetensors");
  const std::string other = protocol("other.json", R"(, "body": {"participant": {"mass_kg": 60, "height_m": 1.65}})");
  run_ok("dataset --quiet --count 20 --seed 9" + other + " -o " + folder / "d.npz");
  CHECK(run_json("evaluate --json --data " + folder / "d.npz" + model).at("trials") == 20);
  // Positions of hip and shoulder, whose segments the body gives.
  std::string header, text = "time,hip_mm,shoulder_mm\n";
  for (const auto& row : read_csv(folder / "trial.csv", header))
    text += decid::format("%.17g,%.17g,%.17g\n", row[0], 15 * row[1], 24 * row[1]);
  write_text(folder / "markers.csv", text);
  const std::string body = " --mass 60 --height 1.9";
  const std::string markers = folder / "markers.csv" + " --hip hip_mm --shoulder shoulder_mm" + body + model;
  const Json identified = first_recording("identify --json " + markers);
  run_ok("export sway --quiet -o " + folder / "sway.bin " + markers);
  const std::string bytes = read_text(folder / "sway.bin");
  std::vector<float> sway_rad(bytes.size() / sizeof(float));
  std::memcpy(sway_rad.data(), bytes.data(), bytes.size());
  const auto [low, high] = std::ranges::minmax(sway_rad);
  CHECK(
      near((high - low) / decid::sim::rad_per_deg, identified.at("peak_to_peak_deg").get<double>(), 1e-5));  // float32
  const std::string study = "study --quiet --json --trials 16 --realisations 3 --sensor-noise 0 -o " + folder / "study";
  const Json studied = run_json(study + " --recording " + markers).at("recording").at("identified");
  for (const Json& parameter : identified.at("parameters"))
    CHECK(studied.at(parameter.at("name").get<std::string>()) == parameter.at("value"));
  check_refused(study + body + model, "--mass");
}
