// decid train as a process: stopped, given again, taken to more epochs, begun with another model's weights; what would
// overwrite another training is refused, and one that diverges leaves nothing.

#include <algorithm>

#include "tests/tools/decid/run.hpp"
#include "tools/decid/commands/train/train_files.hpp"
#include "tools/decid/progress.hpp"

using namespace decid::test;
using Json = nlohmann::json;

namespace {

/// A folder with data sets of trials of 6 s: a.npz and b.npz, of `count` trials each.
class TrainingFolder : public Folder {
 public:
  explicit TrainingFolder(int count) {
    const std::string protocol = quick_protocol(*this);
    for (const auto& [name, seed] : {std::pair("a.npz", "5"), {"b.npz", "6"}})
      run_ok("dataset --quiet --count " + std::to_string(count) + " --seed " + seed + " --protocol " + protocol +
             " -o " + *this / name);
  }
  std::string train(const std::string& options, const std::string& data = "a.npz",
                    const std::string& output = "m.safetensors") const {
    return "train --json --threads 1 --data " + *this / data + " " + options +
           (options.find("--preset") == std::string::npos ? " --preset small" : "") + " -o " + *this / output;
  }
  /// Ctrl-C once an epoch is done; returns standard error.
  static std::string interrupt(const std::string& command) { return interrupted(command, "grep -qs ^epoch $err").err; }
};

std::string hash_values(const Result& result) {
  CAPTURE(result.err);
  REQUIRE(result.code == 0);
  return Json::parse(result.out).at("weights_sha256");
}

}  // namespace

TEST_CASE("train: an interrupted training goes on, with its own data and settings only") {
  const TrainingFolder folder(400);
  const std::string model = folder / "m.safetensors", command = folder.train("--epochs 30");
  CHECK(contains(folder.interrupt(command), "the same command, with --resume or without, continues"));
  CHECK_FALSE(std::filesystem::exists(model));
  const std::string checkpoint = read_text(model + ".checkpoint");
  write_text(folder / "other.txt", "conv 4 5x5 stride 4; relu; fc 7");
  for (const std::string resume : {"", " --resume"}) {
    check_refused(folder.train("--epochs 30" + resume, "b.npz"));
    check_refused(folder.train("--epochs 30 --architecture " + folder / "other.txt" + resume));
    // The message names only the settings that differ.
    const std::string slower = run_decid(folder.train("--epochs 30 --lr 0.001" + resume)).err;
    CHECK(contains(slower, "other settings: learning_rate 0.02 there, 0.001 here;"));
    check_refused(folder.train("--epochs 4" + resume), "epochs 30 there, 4 here");
  }
  check_refused(folder.train("--epochs 40"), "epochs 30 there, 40 here");
  CHECK(read_text(model + ".checkpoint") == checkpoint);
  // To the same bits as in one go.
  const auto went_on = run_decid(command);
  CHECK(contains(went_on.err, "resuming after epoch "));
  CHECK(hash_values(went_on) == hash_values(run_decid(folder.train("--epochs 30", "a.npz", "straight"))));
  CHECK(read_text(model + ".log.csv") == read_text(folder / "straight.log.csv"));
  CHECK(read_text(model) == read_text(folder / "straight"));
  CHECK_FALSE(std::filesystem::exists(model + ".checkpoint"));
}

TEST_CASE("train: the same command again is done, another one overwrites nothing") {
  const TrainingFolder folder(64);
  const std::string model = folder / "m.safetensors", command = folder.train("--epochs 2");
  const auto first = run_ok(command);
  const auto again = run_ok(command);
  CHECK(again.out == first.out);
  CHECK(contains(again.err, "nothing is left to do"));
  CHECK(run_decid(command + " --quiet").err.empty());
  CHECK(run_decid(folder.train("--epochs 2 --resume")).out == first.out);
  // A checkpoint of a training beside the model of another: neither is touched.
  const std::string other = folder / "n.safetensors";
  run_ok(folder.train("--epochs 2 --seed 2", "a.npz", "n.safetensors"));
  folder.interrupt(folder.train("--epochs 100000 --resume"));
  std::filesystem::rename(other, model);
  check_refused(folder.train("--epochs 100000"), "seed 2 there, 1 here");
}

TEST_CASE("train: while one runs, another one of the same output is refused") {
  const TrainingFolder folder(64);
  const std::string program = std::string(DECID_PROGRAM) + " ", err = folder / "err";
  for (const std::string other : {"--epochs 100000", "--epochs 1 --seed 2"}) {
    const std::string line = program + folder.train("--epochs 100000") + " >/dev/null 2>" + err +
                             " & child=$!; while ! grep -qs ^epoch " + err + "; do sleep 0.02; done; " + program +
                             folder.train(other) + " 2>" + folder / "refused" +
                             "; code=$?; kill -INT $child; wait $child; test $code -eq 2";
    CHECK(std::system(line.c_str()) == 0);
    CHECK(contains(read_text(folder / "refused"), "m.safetensors: is being trained by another decid; wait"));
    CHECK(std::filesystem::exists(folder / "m.safetensors.checkpoint"));
    CHECK_FALSE(std::filesystem::exists(folder / "m.safetensors.lock"));
    std::filesystem::remove(err);
  }
}

TEST_CASE("train: --resume goes on to more epochs, and the origin says so") {
  const TrainingFolder folder(64);
  const std::string model = folder / "m.safetensors";
  // From a checkpoint with its momentum buffers: at a constant rate, the bits of one uninterrupted training.
  folder.interrupt(folder.train("--epochs 100000 --schedule constant"));
  std::string log = read_text(model + ".log.csv");
  const auto done = std::count(log.begin(), log.end(), '\n') - 1;
  const std::string more = "--schedule constant --epochs 100001 --resume";
  folder.interrupt(folder.train(more));
  const Json origin = run_json("info --json " + model + ".checkpoint").at("origin");
  CHECK(origin.at("epochs") == 100001);
  REQUIRE(origin.at("extensions").size() == 1);
  CHECK(origin["extensions"][0].at("planned") == 100000);
  CHECK(origin["extensions"][0].at("after") >= done);
  std::filesystem::remove(model + ".checkpoint");
  // From a finished model: the rates are those of the schedule of all epochs.
  run_ok(folder.train("--epochs 2 --schedule step:1:0.5"));
  const std::string begun = read_text(model + ".log.csv");
  const auto longer = run_ok(folder.train("--epochs 4 --schedule step:1:0.5 --resume"));
  CHECK(contains(longer.err, "resuming after epoch 2 of 4"));
  CHECK(Json::parse(longer.out).at("epochs") == 4);
  log = read_text(model + ".log.csv");
  CHECK(log.starts_with(begun));
  CHECK(contains(log, ",0.0025\n"));  // 0.02 / 2^3
  CHECK(run_json("info --json " + model).at("origin").at("extensions").dump() == R"([{"after":2,"planned":2}])");
  CHECK(run_decid(folder.train("--epochs 4 --schedule step:1:0.5 --resume")).out == longer.out);
  CHECK(run_decid(folder.train("--epochs 4 --schedule step:1:0.5")).out == longer.out);
}

TEST_CASE("train: --resume without a training says what it looked for") {
  const TrainingFolder folder(16);
  const Result refused = run_decid(folder.train("--epochs 1 --resume"));
  CHECK(refused.code == 2);
  CHECK(contains(refused.err, "decid: --resume"));
  CHECK(contains(refused.err, "m.safetensors.checkpoint"));
}

TEST_CASE("train: divergence is an error, and leaves nothing") {
  const TrainingFolder folder(64);
  const std::size_t before = folder.files();
  check_refused(folder.train("--quiet --preset best --epochs 3 --lr 1000"), "of 3");
  CHECK(folder.files() == before);
  // The files written before stay.
  run_ok(folder.train("--epochs 1 --lr 5 --schedule constant --patience 40"));
  const std::string model = folder / "m.safetensors", bytes = read_text(model), log = read_text(model + ".log.csv");
  const std::size_t files = folder.files();
  check_refused(folder.train("--quiet --epochs 40 --lr 5 --schedule constant --patience 40 --resume"));
  CHECK(read_text(model) == bytes);
  CHECK(read_text(model + ".log.csv") == log);
  CHECK(folder.files() == files);
}

TEST_CASE("train: a divergence puts back all files that an epoch changed, also a checkpoint within an epoch") {
  const Folder folder;
  const decid::tools::TrainFiles files(folder / "m.safetensors");
  write_text(files.stopped, "stopped");
  write_text(files.checkpoint, "checkpoint");
  const decid::tools::Before before(files.of_epochs());
  std::filesystem::remove(files.stopped);
  for (const std::string& path : {files.checkpoint, files.log, files.best}) write_text(path, "new");
  before.put_back();
  CHECK(read_text(files.stopped) == "stopped");
  CHECK(read_text(files.checkpoint) == "checkpoint");
  CHECK_FALSE(std::filesystem::exists(files.log));
  CHECK_FALSE(std::filesystem::exists(files.best));
}

TEST_CASE("train: fine tuning begins with another model's weights") {
  const TrainingFolder folder(64);
  const std::string base = folder / "base.safetensors";
  const std::string hash = hash_values(run_decid(folder.train("--epochs 12", "a.npz", "base.safetensors")));
  // With a rate of next to nothing it knows the base's trials from the first epoch on.
  const auto first_epoch = [&](const std::string& options, const std::string& output) {
    return run_json(folder.train("--epochs 1 --lr 1e-12" + options, "a.npz", output)).at("training_mse").get<double>();
  };
  CHECK(first_epoch(" --from " + base, "same.safetensors") < 0.8 * first_epoch("", "fresh.safetensors"));
  const auto tuned = run_ok(folder.train("--epochs 1 --from " + base, "b.npz"));
  const Json origin = run_json("info --json " + folder / "m.safetensors").at("origin");
  CHECK(origin.at("from").at("weights_sha256") == hash);
  CHECK(origin.at("from").at("trials")[0].at("kind") == "stored");
  // It is not measured on what the base was trained on either.
  check_refused("evaluate --model " + folder / "m.safetensors" + " --data " + folder / "a.npz", "seed 5");
}

TEST_CASE("train: patience keeps the model of the best epoch") {
  const Folder folder;
  run_ok("dataset --count 160 --seed 5 --protocol " + quick_protocol(folder) + " -o " + folder / "d.npz");
  const std::string train = "train --json --quiet --preset small --schedule constant --data " + folder / "d.npz";
  const Json best = run_json(train + " --epochs 200 --patience 2 -o " + folder / "a.safetensors");
  const int kept = best.at("kept_epoch");
  CHECK(best.at("epochs") == kept + 2);
  // At a constant rate, a shorter training is the beginning of a longer one.
  const Json straight = run_json(train + " --epochs " + std::to_string(kept) + " -o " + folder / "b.safetensors");
  CHECK(best.at("weights_sha256") == straight.at("weights_sha256"));
  CHECK(best.at("validation_mse") == straight.at("validation_mse"));
  CHECK(folder.files() == 6);  // no checkpoint, no best model left beside
}

TEST_CASE("train: a moving average of the weights, of the best epoch too, and taken to more epochs") {
  const std::string average = " --average 0.9";
  const TrainingFolder folder(64);
  const std::string two = hash_values(run_ok(folder.train("--epochs 2" + average)));
  CHECK(two != hash_values(run_ok(folder.train("--epochs 2", "a.npz", "plain"))));
  CHECK_FALSE(contains(read_text(folder / "m.safetensors"), "average."));  // no second network is left in the file
  CHECK(run_json("info --json " + folder / "m.safetensors").at("origin").at("average") == 0.9);
  check_refused(folder.train("--epochs 2"), "average 0.9 there, nothing here");
  // Patience keeps the average of the best epoch, and more epochs go on from the averaged weights.
  const std::string steady = "--quiet --schedule constant --average 0.5";
  const Json best = run_json(folder.train("--epochs 200 --patience 2 " + steady, "a.npz", "p"));
  const std::string kept = std::to_string(best.at("kept_epoch").get<int>());
  const Json shorter = run_json(folder.train("--epochs " + kept + " " + steady, "a.npz", "s"));
  CHECK(best.at("weights_sha256") == shorter.at("weights_sha256"));
  CHECK(best.at("validation_mse") == shorter.at("validation_mse"));
  CHECK(run_json(folder.train("--quiet --epochs 3 --resume" + average)).at("epochs") == 3);
  check_refused(folder.train("--epochs 1 --average 1", "a.npz", "n"));
}

TEST_CASE("train: the report is a page of all epochs, rewritten each time") {
  const TrainingFolder folder(64);
  const std::string command = folder.train("--epochs 3 --report " + folder / "page.html");
  const auto shown = [&] { return page_data(folder / "page.html"); };
  const auto trained = run_ok(command);
  const Json data = shown();
  CHECK(data.at("log").size() == 3);
  CHECK(data.at("epochs") == 3);
  CHECK(data.at("finished") == true);
  const double last = data.at("log")[2].at("validation");  // six digits
  CHECK(near(last, Json::parse(trained.out).at("validation_mse").get<double>(), 1e-5));
  // A training that is done writes it again; one that was stopped has written it.
  std::filesystem::remove(folder / "page.html");
  run_ok(command);
  CHECK(shown() == data);
  folder.interrupt(folder.train("--epochs 100000 --report " + folder / "page.html", "b.npz", "n.safetensors"));
  CHECK(shown().at("finished") == false);
  CHECK(shown().at("log").size() >= 1);
}

TEST_CASE("train: a curve of the loss beside the bar, on a terminal only") {
  using decid::tools::curve;
  CHECK(curve(std::vector<double>{}).empty());
  CHECK(curve(std::vector<double>{3.0}) == "▁");
  CHECK(curve(std::vector<double>{128.0, 64.0, 2.0, 1.0}) == "█▇▂▁");
  CHECK(curve(std::vector<double>{7.0, 0.0}) == "█▁");
  CHECK(curve(std::vector<double>{9.0, 2.0, 1.0}, 2) == "█▁");
  const TrainingFolder folder(64);
  const std::string command = folder.train("--epochs 100");
  CHECK_FALSE(contains(run_decid(command).err, "▁"));
  std::filesystem::remove(folder / "m.safetensors");
  REQUIRE(std::system(
              ("script -qec \"" DECID_PROGRAM " " + command + "\" " + folder / "screen" + " >/dev/null").c_str()) == 0);
  const std::string screen = read_text(folder / "screen");
  CHECK(contains(screen, "\rtrain: ["));
  CHECK(contains(screen, ", validation MSE "));
  CHECK(contains(screen, "▁"));
}
