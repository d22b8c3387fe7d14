// Input at the edge of what the program refuses: what is accepted. tests/golden/messages.txt has what is refused.

#include <sstream>

#include "tests/tools/decid/run.hpp"

using namespace decid::test;

namespace {

/// A recording of the default protocol's length; `cell(k)` gives the sway of sample k.
template <class Cell>
std::string recording(int samples, double rate, const Cell& cell) {
  std::string text = "time,com_sway_deg\n";
  for (int k = 0; k < samples; ++k) text += std::to_string(k / rate) + "," + cell(k) + "\n";
  return text;
}

}  // namespace

TEST_CASE("zeros before a seed do not make it octal, and the largest seed is one") {
  const Folder folder;
  for (const std::string seed : {"8", "10", "010"}) run_ok("simulate --quiet --seed " + seed + " -o " + folder / seed);
  CHECK(read_text(folder / "010") == read_text(folder / "10"));
  CHECK(read_text(folder / "8") != read_text(folder / "10"));
  CHECK(run_decid("simulate --seed 18446744073709551615 --quiet -o /dev/null").code != 2);
}

TEST_CASE("an error's advice works") {
  const Folder folder;
  const std::string mine = folder / "mine.json", cut = folder / "cut.csv";
  // A trial that was stopped early: its protocol with fewer cycles, written as the error says.
  const std::string protocol = " --protocol short";
  run_ok("simulate --quiet -o " + folder / "t.csv" + protocol);
  std::istringstream trial(read_text(folder / "t.csv"));
  std::string text, line;
  for (int k = 0; k <= 6000 && std::getline(trial, line); ++k) text += line + "\n";
  write_text(cut, text);
  const std::string fit = "fit --quiet --max-draws 8 " + cut;
  const std::string error = run_decid(fit + protocol).err, cycles = "set its cycles to ";
  const std::string number = error.substr(error.find(cycles) + cycles.size(), 1);
  run_ok("stimulus --quiet" + protocol + " --write-protocol " + mine);
  std::string changed = read_text(mine);
  write_text(mine, changed.replace(changed.find("\"cycles\": ") + 10, 1, number));
  run_ok(fit + " --protocol " + mine);
}

TEST_CASE("a wrong unit is suspected, not refused") {
  const Folder folder;
  write_text(folder / "big.csv",
             recording(12100, 100, [](int k) { return std::to_string(12.5 * ((k / 70) % 5 - 2)); }));
  write_text(folder / "small.csv", recording(12100, 100, [](int k) { return std::to_string((k / 70) % 5) + "e-5"; }));
  for (const std::string name : {"big.csv", "small.csv"}) {
    const auto result = run_decid("identify " + folder / name);
    CAPTURE(name);
    CHECK(result.code == 0);
    CHECK(contains(result.out, "--unit"));
    CHECK(result.out.find("sway reaches") == result.out.rfind("sway reaches"));  // said once
  }
}

TEST_CASE("an output may have another ending, or none; a page has one of two") {
  const Folder folder;
  const std::string trial = folder / "t.csv";
  run_ok("simulate --quiet -o " + trial);
  for (const char* name : {"all", "all.2024", "all.JSON", "all.json.part"})
    run_ok("identify " + trial + " -o " + folder / name + " --report " + folder / "page.HTM");
  for (const char* name : {"all", "all.txt", "all.DAT"}) run_ok("identify " + trial + " --table " + folder / name);
  // Programs would open these as something else.
  for (const auto& [option, name] : {std::pair("--table ", "all.ods"),
                                     {"--long ", "all.doc"},
                                     {"-o ", "all.yaml"},
                                     {"--report ", "all.txt"},
                                     {"-o ", "all.json.gz"}})
    check_refused("identify " + trial + " " + option + folder / name, "would hold");
  check_refused("fit " + trial + " --draws " + folder / "d.txt", "d.npz");
}

TEST_CASE("a folder that is written is made, or is there") {
  const Folder folder;
  const std::string study = "study --quiet --trials 2 --realisations 2 --sensor-noise 0 -o ";
  for (const std::string& command : {study, std::string("export controller --quiet -o ")}) {
    CAPTURE(command);
    for (const char* name : {"made/", "with.json"}) {
      if (std::string(name) == "with.json")
        std::filesystem::create_directory(folder / name);  // there, it is no mistake
      run_ok(command + folder / name);
      CHECK(std::filesystem::exists(folder / name + (command == study ? "/study.json" : "/decid_controller.c")));
    }
  }
}
