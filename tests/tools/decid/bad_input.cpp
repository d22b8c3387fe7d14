// Bad input: one clear line on standard error, exit code 2, nothing on standard output, and no file half-written.

#include <algorithm>
#include <sstream>
#include <utility>

#include "tests/tools/decid/run.hpp"

using namespace decid::test;

namespace {

/// Writes `text` as a recording and expects identify to refuse it, leaving neither JSON nor report.
void check_recording_refused(const std::string& text, std::initializer_list<std::string> fragments,
                             const std::string& options = "") {
  const Folder folder;
  write_text(folder / "r.csv", text);
  check_refused(
      "identify " + folder / "r.csv" + " -o " + folder / "o.json" + " --report " + folder / "o.html" + " " + options,
      fragments);
  CHECK(folder.files() == 1);
}

/// A recording of the default protocol's length; `cell(k)` gives the sway of sample k.
template <class Cell>
std::string recording(int samples, double rate, const Cell& cell) {
  std::string text = "time,com_sway_deg\n";
  for (int k = 0; k < samples; ++k) text += std::to_string(k / rate) + "," + cell(k) + "\n";
  return text;
}
std::string wave(int k) {
  return std::to_string(0.3 * ((k / 7) % 5 - 2));
}

}  // namespace

TEST_CASE("no output replaces an input of the call") {
  const Folder folder;
  run_ok("stimulus --quiet -o " + folder / "tilt.csv");
  write_text(folder / "p.json", R"({"name": "p", "measured": {"file": "tilt.csv", "column": "tilt_deg"}})");
  write_text(folder / "image.json", R"({"window": 110})");
  write_text(folder / "r.csv", "time,com_sway_deg\n0,0\n0.01,0\n");
  std::filesystem::create_symlink("tilt.csv", folder / "link.csv");
  const std::string tilt = read_text(folder / "tilt.csv");
  const std::string with = " --quiet --protocol " + folder / "p.json";
  const std::string quick = " --stream --preset small --stream-trials 16 --validation-trials 4 --epochs 1";
  // By names without an ending: another format's would be refused before.
  for (const std::string name : {"p.json", "tilt.csv", "link.csv", "image.json"})
    std::filesystem::create_symlink(name, folder / "as-" + name.substr(0, name.find('.')));
  for (const std::string output : {"as-p", "as-tilt", "as-link"}) {
    const std::string o = " -o " + folder / output;
    check_refused("simulate" + with + o, {output, "read or written already"});
    check_refused("dataset --count 3" + with + o, {output, "read or written already"});
    check_refused("dataset --count 3" + with + " -o " + folder / "d.npz" + " --report " + folder / output,
                  {output, "read or written already"});
    check_refused("train" + quick + with + o, {output, "read or written already"});
    check_refused("fit " + folder / "r.csv" + with + o, {output, "read or written already"});
  }
  check_refused("train" + quick + " --image " + folder / "image.json" + " -o " + folder / "as-image",
                {"as-image", "read or written already"});
  CHECK(read_text(folder / "tilt.csv") == tilt);
  CHECK(folder.files() == 9);
  write_text(folder / "m", "a model");
  check_refused("export sway " + folder / "r.csv" + " --model " + folder / "m" + " -o " + folder / "m",
                {"m", "read or written already"});
  // A built-in protocol's name is not a file.
  CHECK(run_decid("dataset --count 3 --quiet -o " + folder / "default").code == 0);
}

TEST_CASE("errors name the cause of a fall and a remedy") {
  const Folder folder;
  const std::string o = " --quiet -o " + folder / "t.csv";
  check_refused("simulate --kp 0" + o, {"leaves 5 degrees", "must exceed", "raise --kp"});
  check_refused("simulate --nv 10" + o, {"without vestibular noise it stands", "--nv"});
  check_refused("simulate --delay 0.5" + o, {"shorten --delay"});
  check_refused("simulate --model dip --hip-delay 0.5" + o, {"leg or trunk", "nearer to their defaults"});
  write_text(folder / "p.json", R"({"sequence": {"amplitude_deg": 45}, "vestibular_noise": {"scale_deg": 0}})");
  check_refused("simulate --kp-pass 300 --protocol " + folder / "p.json" + o, {"platform at rest", "amplitude"});
  // A band that holds harmonics of this trial only.
  write_text(folder / "p.json",
             R"({"sines": {"components": [{"frequency_hz": 0.1, "amplitude_deg": 40}], "cycle_s": 600},
                                    "vestibular_noise": {"low_hz": 0.002, "high_hz": 0.004}})");
  check_refused("simulate --kp-pass 300 --protocol " + folder / "p.json" + o, {"leaves 5 degrees", "amplitude"});
  CHECK(folder.files() == 1);
}

TEST_CASE("a full standard output is no success") {
  const Folder folder;
  for (const std::string arguments : {"info --json", "--help", "--version", "train --help"}) {
    CAPTURE(arguments);
    const std::string command = DECID_PROGRAM " " + arguments + " > /dev/full 2> " + folder / "err";
    const int status = std::system(command.c_str());
    CHECK(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == 1);
    CHECK(contains(read_text(folder / "err"), "standard output"));
  }
}

namespace {

/// The disk fails: exit code 1, nothing on standard output, one line of the program's that has the fragments.
void check_unwritten(const Result& result, std::initializer_list<std::string> fragments) {
  CAPTURE(result.err);
  CHECK(result.code == 1);
  CHECK(result.out.empty());
  CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
  CHECK(result.err.starts_with("decid: "));
  for (const std::string& fragment : fragments) CHECK(contains(result.err, fragment));
}

}  // namespace

TEST_CASE("a full disk is exit code 1, and leaves the old files") {
  const Folder folder;
  const std::string trial = folder / "t.csv";
  run_ok("simulate --quiet -o " + trial);
  for (const std::string& command :
       {"identify " + trial + " -o ", "identify " + trial + " --table ", "identify " + trial + " --report ",
        std::string("simulate -o "), std::string("stimulus --plot "), std::string("stimulus --write-protocol "),
        std::string("dataset --count 3 -o " + folder / "d.npz" + " --report ")}) {
    CAPTURE(command);
    check_unwritten(run_decid(command + "/dev/full --quiet"), {"/dev/full: ", "No space left", "free space"});
    std::filesystem::remove(folder / "d.npz");
  }
  CHECK(folder.files() == 1);
  // A limit on the size of files stands for a full disk: of blocks of 512 or 1024 bytes.
  const auto limited = [&](const std::string& arguments, const std::string& name) {
    CAPTURE(arguments);
    write_text(folder / name, "old");
    check_unwritten(run_decid(arguments + folder / name, "ulimit -f 8; "), {name + ": ", "File too large"});
    CHECK(read_text(folder / name) == "old");
  };
  limited("simulate --quiet -o ", "a.csv");
  limited("identify --quiet " + trial + " --report ", "a.html");
  limited("export onnx --quiet " DECID_SOURCE_DIR "/models/built_in.safetensors -o ", "a.onnx");
  CHECK(folder.files() == 4);
}

TEST_CASE("wrong usage") {
  check_refused("", {"--help"});
  check_refused("identfy x.csv", {"identfy", "not a command", "--help"});
  // A shell passes an empty argument for a variable that is not set.
  check_refused("simulate --kp '' -o x.csv", {"--kp ''", "is empty"});
  check_refused("simulate --kp= -o x.csv", {"--kp=", "is empty"});
  check_refused("dataset --count 5 --sensor-noise '' -o x.npz", {"--sensor-noise ''", "is empty"});
  check_refused("identify x.csv --mass 70 --height 175", {"--height: 175 is not from 0.3 to 3 m"});
  check_refused("identify x.csv --mass 70 --height tall", {"--height", "tall"});
  check_refused("dataset --count 5 -o ''", {"-o ''", "is empty"});
  check_refused("''", {"is empty"});
  for (const std::string seed : {"-1", "18446744073709551616", "1.5", "1x"})
    check_refused("simulate --seed " + seed + " -o x.csv", {"--seed", "'" + seed + "'", "18446744073709551615"});
  CHECK(run_decid("simulate --seed 18446744073709551615 --quiet -o /dev/null").code != 2);
  // Zeros before a number do not make it octal.
  const Folder folder;
  for (const std::string seed : {"8", "08", "10", "010"})
    CHECK(run_decid("simulate --quiet --seed " + seed + " -o " + folder / seed).code == 0);
  CHECK(read_text(folder / "08") == read_text(folder / "8"));
  CHECK(read_text(folder / "010") == read_text(folder / "10"));
  CHECK(read_text(folder / "8") != read_text(folder / "10"));
  check_refused("simulate", {"--output", "simulate --help"});
  check_refused("simulate --kp abc -o x.csv", {"--kp", "abc"});
  check_refused("simulate --kp nan -o x.csv", {"Kp"});
  check_refused("simulate --kp -5 -o x.csv", {"Kp"});
  check_refused("simulate --delay 50 -o x.csv", {"delay"});
  check_refused("simulate --model tripod -o x.csv", {"tripod"});
  check_refused("simulate --threads 0 -o x.csv", {"--threads"});
  check_refused("dataset --count 0 -o x.npz", {"--count"});
  check_refused("dataset --count -3 -o x.npz", {"--count"});
  check_refused("dataset --count 10 --base 20 -o x.npz", {"20", "10"});
  check_refused("dataset --count 99999999999 -o x.npz", {"--count"});
  check_refused("train -o m.safetensors", {"--data", "--stream"});
  check_refused("train --stream --preset nope -o m.safetensors", {"nope", "best"});
  check_refused("train --stream --schedule zigzag -o m.safetensors", {"zigzag", "cosine"});
  check_refused("identify x.csv --truth Kp=1", {"--truth", "7"});
  check_refused("identify x.csv --unit furlong", {"furlong"});
  CHECK_FALSE(std::filesystem::exists("x.csv"));
  CHECK_FALSE(std::filesystem::exists("x.npz"));
  // No command writes to standard output under that name.
  for (const std::string command :
       {"simulate", "stimulus", "dataset --count 4", "train --stream", "identify x.csv", "identify x.csv --json",
        "fit x.csv", "compare", "study", "export c", "export controller", "export sway x.csv"}) {
    check_refused(command + " -o -", {"--output", "'-' is no file", "--json"});
    check_refused(command + " --output=-", {"'-' is no file"});
  }
  CHECK_FALSE(std::filesystem::exists("-"));
}

TEST_CASE("help gives units apart from figures") {
  const std::string help = run_decid("simulate --help").out;
  CHECK(contains(help, "N m/rad"));
  for (const char* joined : {"0N m", "1N m", "2N m", "3N m", "4N m", "5N m", "6N m", "7N m", "8N m", "9N m"})
    CHECK_FALSE(contains(help, joined));
}

TEST_CASE("parameters that do not stand write no trial") {
  const Folder folder;
  check_refused("simulate --kp 1258 --kd 126 --delay 0.24 -o " + folder / "t.csv", {"5 degrees", "--delay"});
  CHECK(folder.files() == 0);
}

TEST_CASE("recordings that cannot be used") {
  check_refused("identify /nowhere/r.csv", {"/nowhere/r.csv"});
  check_refused("identify /", {"/"});
  check_recording_refused("", {"r.csv", "no lines"});
  check_recording_refused("time,com_sway_deg\n", {"r.csv"});
  check_recording_refused("time,com_sway_deg\n0,0.1\n0.01,zero\n0.02,0.1\n", {"line 3", "zero"});
  check_recording_refused("time,com_sway_deg\n0,0.1\n0.01,nan\n0.02,0.1\n", {"line 3"});
  check_recording_refused("time,com_sway_deg\n0,0.1\n0.01,inf\n0.02,0.1\n", {"line 3"});
  check_recording_refused("time,com_sway_deg\n0,0.1\n0.01\n0.02,0.1\n", {"line 3"});
  check_recording_refused("time,elbow\n0,0.1\n0.01,0.2\n0.02,0.1\n", {"wrist", "elbow"}, "--column wrist");
  check_recording_refused(recording(12100, 100, [](int) { return std::string("0.25"); }), {"constant"});
  check_recording_refused(recording(12100, 100, [](int k) { return std::to_string(k % 200); }),
                          {"lying flat", "--unit"});
  check_recording_refused("time,COM_x_mm\n0,0.1\n0.01,0.2\n0.02,0.1\n", {"COM_x_mm", "length", "height"});
  check_recording_refused("time,sway_deg/s\n0,0.1\n0.01,0.2\n0.02,0.1\n", {"sway_deg/s", "a velocity", "--unit"});
  check_recording_refused("time,sway,sway\n0,0.1,1\n0.01,0.2,2\n", {"numbers 2 and 3", "--column"});
  check_recording_refused(recording(12100, 100, wave), {"'time'", "the time column", "--column"}, "--column time");
  check_recording_refused(recording(12100, 0.1, wave), {"0.1 Hz", "milliseconds", "time_ms"});
  check_recording_refused("{\n  \"model\": \"built-in model\"\n}\n", {"r.csv", "is JSON"});
  check_recording_refused(std::string("\x00\x01\x02\xff\xfe binary", 12), {"r.csv"});
}

TEST_CASE("recordings of another length or rate are refused with both and a way out") {
  check_recording_refused(recording(6370, 100, wave), {"6370", "12100", "100 Hz", "--stream"});
  check_recording_refused(recording(6370, 60, wave),
                          {"6370", "60 Hz", "12100", "100 Hz", "only 1 of its 2 whole cycles", "--stream"});
  check_recording_refused(recording(12100, 100, wave), {"12100", "200 Hz", "100 Hz"}, "--rate 200");
  check_recording_refused(recording(12200, 100, wave), {"--begin", "122 s"}, "--begin 130");
  check_recording_refused(recording(20, 100, wave), {"20", "12100"});
}

TEST_CASE("an error's advice works") {
  const Folder folder;
  const std::string mine = folder / "mine.json", cut = folder / "cut.csv";
  // A trial that was stopped early: its protocol with fewer cycles, written as the error says.
  for (const auto& [protocol, seconds] : {std::pair("", 90), {" --protocol short", 60}}) {
    run_ok(std::string("simulate --quiet -o ") + folder / "t.csv" + protocol);
    std::istringstream trial(read_text(folder / "t.csv"));
    std::string text, line;
    for (int k = 0; k <= 100 * seconds && std::getline(trial, line); ++k) text += line + "\n";
    write_text(cut, text);
    const std::string fit = "fit --quiet --max-draws 8 " + cut;
    const std::string says =
        std::string("write its protocol (decid stimulus") + protocol + " --write-protocol mine.json)";
    check_refused(fit + protocol, {says, "set its cycles to ", "--protocol"});
    const std::string error = run_decid(fit + protocol).err, cycles = "set its cycles to ";
    const std::string number = error.substr(error.find(cycles) + cycles.size(), 1);
    run_ok(std::string("stimulus --quiet") + protocol + " --write-protocol " + mine);
    std::string changed = read_text(mine);
    const std::size_t at = changed.find("\"cycles\": ") + 10;
    write_text(mine, changed.replace(at, 1, number));
    CHECK(run_decid(fit + " --protocol " + mine).code == 0);
  }
  // Another protocol's file is the user's own.
  write_text(mine, R"({"sequence": {"amplitude_deg": 0.7}})");
  write_text(cut, recording(9000, 100, wave));
  check_refused("fit " + cut + " --protocol " + mine, {"copy its protocol's file, set its cycles to 1"});
  // A table of a frequency response.
  const std::string table = DECID_SOURCE_DIR "/examples/frf.csv";
  check_refused("fit " + table, {"is a frequency response, not a recording", "fit it with --frf " + table});
  check_refused("identify " + table, {"fit it with --frf " + table});
  check_refused("fit --frf " + cut, {"no column called frequency", "leave --frf out for a recording"});
}

TEST_CASE("a gap that is too long for --fill-gaps is not advised to be filled") {
  check_recording_refused(recording(12100, 100, [](int k) { return k > 100 && k < 6200 ? std::string() : wave(k); }),
                          {"(60.99 s)", "too long to interpolate"}, "--fill-gaps 60");
  check_recording_refused(recording(12100, 100, [](int k) { return k > 100 && k < 5200 ? std::string() : wave(k); }),
                          {"--fill-gaps 50.99 interpolates"}, "--fill-gaps 1");
}

TEST_CASE("options of a recording that contradict each other or are none") {
  const std::string text = recording(12100, 100, wave);
  check_recording_refused(text, {"--tilt-unit", "--tilt-column"}, "--tilt-unit deg");
  check_recording_refused(text, {"--invert", "--tilt-column"}, "--invert tilt");
  check_recording_refused(text, {"--begin", "--tilt-column"}, "--begin 1 --tilt-column 1");
  check_recording_refused(text, {"no column 'tilt'"}, "--tilt-column tilt");
  check_recording_refused(text, {"is already the sway"}, "--tilt-column com_sway_deg");
  check_recording_refused(text, {"--detrend"}, "--detrend cubic");
  check_recording_refused(text, {"--fill-gaps"}, "--fill-gaps -1");
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

TEST_CASE("outputs that would replace inputs or other outputs") {
  const Folder folder;
  const std::string trial = folder / "trial";
  run_ok("simulate -o " + trial);
  const std::string before = read_text(trial);
  check_refused("identify " + trial + " -o " + trial, {trial, "another name"});
  check_refused("identify " + trial + " --report " + folder / "./trial", {"another name"});
  check_refused("identify " + trial + " -o " + folder / "x" + " --report " + folder / "x", {"another name"});
  check_refused("train --data " + trial + " -o " + trial, {"another name"});
  CHECK(read_text(trial) == before);
  CHECK(folder.files() == 1);
}

TEST_CASE("a name that ends like another format, or is a folder's, is refused with the right one") {
  const Folder folder;
  run_ok("simulate --quiet -o " + folder / "t.csv");
  const std::string trial = folder / "t.csv";
  const auto refused = [&](const std::string& command, const std::string& name, const std::string& right) {
    check_refused(command + " " + folder / name, {"'" + folder / name + "' would hold", "call it '" + folder / right});
  };
  refused("identify " + trial + " -o", "all.csv", "all.json");
  refused("identify " + trial + " --report", "page.PDF", "page.html");
  refused("fit " + trial + " -o", "all.csv", "all.json");
  refused("fit " + trial + " --draws", "draws.csv", "draws.npz");
  refused("fit " + trial + " --report", "all.json", "all.html");
  refused("calibrate -o", "c.npz", "c.json");
  refused("calibrate --figure", "c.png", "c.svg");
  refused("compare -o", "c.html", "c.json");
  refused("compare --report", "c.svg", "c.html");
  refused("simulate -o", "t.mat", "t.csv");
  refused("stimulus -o", "t.json", "t.csv");
  refused("stimulus --plot", "t.png", "t.html");
  refused("stimulus --write-protocol", "p.csv", "p.json");
  refused("dataset --count 3 -o", "data.csv", "data.npz");
  refused("dataset --count 3 -o " + folder / "d.npz" + " --report", "d.csv", "d.html");
  refused("train --stream -o", "model.npz", "model.safetensors");
  refused("export sway " + trial + " -o", "s.csv", "s.bin");
  for (const char* command : {"export c -o ", "export controller -o ", "study -o "})
    check_refused(command + (folder / "posture.c"), {"would be a folder", ".c like a file"});
  for (const std::string& command :
       {"identify " + trial + " -o ", std::string("dataset --count 3 -o "), std::string("train --stream -o ")})
    for (const std::string& name : {folder / "", folder / "missing/", std::string(".")})
      check_refused(command + name, {"'" + name + "' is a folder, and one file is written", "result."});
  CHECK(folder.files() == 1);
  // Other endings, or none, say nothing; those of pages are two.
  for (const char* name : {"all", "all.2024", "all.txt", "all.csv.json", "all.JSON"})
    CHECK(run_decid("identify " + trial + " -o " + folder / name).code == 0);
  CHECK(run_decid("identify " + trial + " --report " + folder / "page.HTM").code == 0);
  CHECK(run_decid("identify " + trial + " -o /dev/null").code == 0);
}

TEST_CASE("a folder that is written is made, where the folder around it is there, as for a file") {
  const Folder folder;
  run_ok("simulate --quiet -o " + folder / "t.csv");
  write_text(folder / "file", "");
  const std::string study = "study --quiet --trials 2 --realisations 2 --sensor-noise 0 -o ";
  for (const std::string& command : {study, std::string("export controller --quiet -o ")}) {
    CAPTURE(command);
    check_refused(command + folder / "no/such", {"its folder does not exist; create the folder " + folder / "no"});
    check_refused(command + folder / "file", {"is a file; give the name of a folder"});
    check_refused(command + folder / "file/in", {"cannot be made a folder"});
    for (const char* name : {"made", "made/", "with_slash/", "with.json"}) {
      if (std::string(name) == "with.json")
        std::filesystem::create_directory(folder / name);  // there, it is no mistake
      CHECK(run_decid(command + folder / name).code == 0);
      CHECK(std::filesystem::exists(folder / name + (command == study ? "/study.json" : "/decid_controller.c")));
    }
  }
  check_refused("identify " + folder / "t.csv" + " -o " + folder / "no/r.json",
                {"its folder does not exist; create the folder " + folder / "no"});
}

TEST_CASE("options without effect are refused") {
  check_refused("train --data d.npz --sensor-noise 0.1 -o m.safetensors", {"--sensor-noise", "--stream"});
  check_refused("train --data d.npz --protocol short -o m.safetensors", {"--protocol", "--stream"});
  check_refused("simulate --seed -1 -o x.csv", {"--seed"});
}

TEST_CASE("outputs that cannot be written") {
  const Folder folder;
  run_ok("simulate -o " + folder / "t.csv");
  const std::string trial = folder / "t.csv";
  check_refused("simulate -o /nowhere/t.csv", {"/nowhere"});
  check_refused("simulate -o " + folder / "", {""});
  check_refused("identify " + trial + " -o /nowhere/o.json", {"/nowhere"});
  // The JSON is not written when the report cannot be.
  check_refused("identify " + trial + " -o " + folder / "o.json" + " --report /nowhere/o.html", {"/nowhere"});
  check_refused("dataset --count 4 -o " + trial + "/d.npz", {"d.npz"});
  check_refused("train --stream -o /nowhere/m.safetensors", {"/nowhere"});
  CHECK(folder.files() == 1);
}

TEST_CASE("damaged model files and data sets") {
  const Folder folder;
  const std::string data = folder / "d.npz", model = folder / "m.safetensors", bad = folder / "bad";
  run_ok("dataset --count 16 --protocol " + quick_protocol(folder) + " -o " + data);
  run_ok("train --preset small --epochs 1 --batch 8 --data " + data + " -o " + model);
  const std::string bytes = read_text(model), archive = read_text(data);
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{7}, std::size_t{100}, bytes.size() / 2, bytes.size() - 1}) {
    write_text(bad, bytes.substr(0, size));
    check_refused("info " + bad, {bad});
    check_refused("identify --model " + bad + " " + data, {bad});
  }
  std::string changed = bytes;
  const std::size_t format = changed.find("decid model");
  REQUIRE(format != std::string::npos);
  changed[format] = 'D';
  write_text(bad, changed);
  check_refused("info " + bad, {"format"});
  changed = bytes;
  changed.back() = static_cast<char>(changed.back() ^ 1);
  write_text(bad, changed);
  check_refused("info " + bad, {bad, "is damaged"});
  changed.replace(changed.find("\"sha256\""), 8, "\"sha257\"");                // no hash
  changed.replace(changed.size() - 4, 4, std::string("\x00\x00\xc0\x7f", 4));  // NaN
  write_text(bad, changed);
  check_refused("info " + bad, {"finite"});
  for (const std::size_t size : {std::size_t{0}, std::size_t{30}, archive.size() / 2, archive.size() - 1}) {
    write_text(bad, archive.substr(0, size));
    check_refused("evaluate --data " + bad, {bad});
    check_refused("train --data " + bad + " -o " + folder / "new.safetensors", {bad});
  }
  check_refused("train --resume --preset small --data " + data + " -o " + folder / "new.safetensors",
                {"new.safetensors.checkpoint"});
  CHECK_FALSE(std::filesystem::exists(folder / "new.safetensors"));
  check_refused("evaluate --data " + data, {"another experiment", "'default'"});
}

TEST_CASE("protocol files that cannot be used") {
  const Folder folder;
  const auto check = [&](const std::string& text, std::initializer_list<std::string> fragments) {
    write_text(folder / "p.json", text);
    check_refused("stimulus --protocol " + folder / "p.json" + " -o " + folder / "s.csv", fragments);
    CHECK(folder.files() == 1);
  };
  check_refused("stimulus --protocol nonsense -o x.csv", {"nonsense"});
  check("", {"p.json"});
  check("{", {"p.json"});
  check("[]", {"p.json"});
  check(R"({"amplitude": 2})", {"amplitude"});
  check(R"({"sequence": {"cycles": 0}})", {"cycles"});
  check(R"({"sequence": {"state_s": 1e-10, "offset_s": 0, "lead_in_s": 1.0}})", {"state_s"});
  check(R"({"sequence": {"cycles": 1000000}})", {"p.json"});
  check(R"({"sample_rate_hz": 333})", {"sample_rate_hz"});
  check(R"({"sample_rate_hz": "fast"})", {"sample_rate_hz"});
}
