// Data sets and evaluation through C: the files and figures of the library.

#include "identify/evaluation/calibration.hpp"
#include "identify/network/prediction.hpp"
#include "identify/training/training.hpp"
#include "tests/bindings/c/owned.hpp"

namespace decid {
namespace {

using namespace test;

constexpr int trials = 40;

decid_dataset_options request() {
  decid_dataset_options options;
  decid_dataset_defaults(&options, sizeof options);
  options.count = trials;
  options.seed = 99;
  return options;
}

OwnedDataset make_dataset(const decid_dataset_options& options) {
  const OwnedProtocol played = protocol("default");
  return make<OwnedDataset>([&](decid_dataset** place) { return decid_dataset_make(played.get(), &options, place); });
}

}  // namespace

TEST_CASE("a data set equals the library's, in memory, written, and generated into a file") {
  const dataset::Dataset expected =
      dataset::generate({.protocol = sim::default_protocol(), .count = trials, .seed = 99});
  const OwnedDataset data = make_dataset(request());
  REQUIRE(decid_dataset_trials(data.get()) == trials);
  const float* sway = decid_dataset_sway(data.get());
  CHECK(std::equal(expected.sway.begin(), expected.sway.end(), sway));
  for (std::size_t i = 0; i < trials; ++i) {
    CHECK(std::equal(expected.parameters[i].begin(), expected.parameters[i].end(),
                     decid_dataset_parameters(data.get()) + 7 * i));
    CHECK(decid_dataset_group(data.get())[i] == expected.group[i]);
    CHECK(decid_dataset_split(data.get())[i] == expected.split[i]);
  }
  CHECK(decid_protocol_samples(decid_dataset_protocol(data.get())) == 12100);

  const TemporaryFolder folder;
  dataset::write_npz(folder / "expected.npz", expected);
  const std::string written = folder / "written.npz", made = folder / "made.npz";
  REQUIRE(decid_dataset_write(data.get(), written.c_str()) == DECID_OK);
  CHECK(read_text(written) == read_text(folder / "expected.npz"));
  decid_dataset_options straight = request();
  straight.path = made.c_str();
  const OwnedDataset stored = make_dataset(straight);
  CHECK(read_text(made) == read_text(folder / "expected.npz"));
  CHECK(decid_dataset_sway(stored.get()) == nullptr);
  refused(decid_dataset_write(stored.get(), written.c_str()), Code::setting_conflict);

  const OwnedDataset again =
      make<OwnedDataset>([&](decid_dataset** place) { return decid_dataset_read(made.c_str(), place); });
  std::vector<float> copied(2 * 12100);
  REQUIRE(decid_dataset_copy_sway(again.get(), 3, 2, copied.data()) == DECID_OK);
  CHECK(std::equal(copied.begin(), copied.end(), sway + 3 * 12100));
  refused(decid_dataset_copy_sway(again.get(), trials, 1, copied.data()), Code::setting_out_of_range, "40 to");
  refused(decid_dataset_copy_sway(again.get(), 1, SIZE_MAX, copied.data()), Code::setting_out_of_range, "40");
  decid_dataset* none = nullptr;
  refused(decid_dataset_read("no.npz", &none), Code::file_missing, "no.npz");
}

TEST_CASE("an empty path is refused before the work") {
  decid_dataset_options options = request();
  options.path = "";
  int calls = 0;
  options.user = &calls;
  options.progress = [](void* user, double, const char*) { return ++*static_cast<int*>(user), 0; };
  const OwnedProtocol played = protocol("default");
  decid_dataset* dataset = nullptr;
  refused(decid_dataset_make(played.get(), &options, &dataset), Code::setting_missing, "decid_dataset_make");
  CHECK(calls == 0);
  options.path = nullptr;
  const OwnedDataset data = make_dataset(options);
  refused(decid_dataset_write(data.get(), ""), Code::setting_missing, "decid_dataset_write");
  refused(decid_model_save(built_in(), ""), Code::setting_missing, "decid_model_save");
}

TEST_CASE("a callback stops a data set") {
  decid_dataset_options options = request();
  options.count = 100000;
  double last = -1.0;
  options.user = &last;
  options.progress = [](void* user, double done, const char*) {
    *static_cast<double*>(user) = done;
    return 1;
  };
  const OwnedProtocol played = protocol("default");
  decid_dataset* dataset = nullptr;
  refused(decid_dataset_make(played.get(), &options, &dataset), Code::stopped, "decid_dataset_make");
  CHECK(dataset == nullptr);
  CHECK(last >= 0.0);
  CHECK(last < 0.5);
}

TEST_CASE("a model's error is the library's") {
  const OwnedDataset data = make_dataset(request());
  decid_evaluation found;
  REQUIRE(decid_evaluate(built_in(), data.get(), DECID_ALL, &found, sizeof found) == DECID_OK);
  const dataset::Dataset same = dataset::generate({.protocol = sim::default_protocol(), .count = trials, .seed = 99});
  const Model model = built_in_model();
  const std::vector<float> outputs = predict(model, trials, 64, sways_in_memory([&](int i) { return same.trial(i); }));
  const Evaluation expected = evaluate(model.targets, to_scores(model, outputs), same.parameters);
  CHECK(found.trials == trials);
  CHECK(found.mse == expected.mse());
  CHECK(found.matlab_loss == expected.matlab_loss());
  CHECK(std::equal(expected.mse_per_parameter.begin(), expected.mse_per_parameter.end(), found.mse_per_parameter));
  const auto calibration = network_calibration(model, outputs, same.parameters);
  CHECK(found.coverage90 == calibration->figures.all.coverage90);
  CHECK(found.log_score == calibration->figures.log_score);

  decid_evaluation half;
  REQUIRE(decid_evaluate(built_in(), data.get(), DECID_VALIDATION, &half, sizeof half) == DECID_OK);
  CHECK(half.trials == trials / 2);
  CHECK(half.mse != found.mse);
}

TEST_CASE("a model is not measured on trials of its training's seed, nor on another experiment") {
  decid_evaluation found;
  decid_dataset_options options = request();
  options.seed = 1;
  const OwnedDataset trained = make_dataset(options);
  refused(decid_evaluate(built_in(), trained.get(), DECID_ALL, &found, sizeof found), Code::data_reused);
  const OwnedProtocol other = protocol("short");
  const decid_dataset_options asked = request();
  const OwnedDataset data =
      make<OwnedDataset>([&](decid_dataset** place) { return decid_dataset_make(other.get(), &asked, place); });
  refused(decid_evaluate(built_in(), data.get(), DECID_ALL, &found, sizeof found), Code::file_differs);
  refused(decid_evaluate(built_in(), data.get(), 3, &found, sizeof found), Code::setting_unknown,
          "there is no split 3");
  refused(decid_evaluate(built_in(), data.get(), DECID_ALL, nullptr, sizeof found), Code::setting_missing);
  for (const std::size_t size : {std::size_t{0}, std::size_t{3}, sizeof found - 1, sizeof found + 8})
    refused(decid_evaluate(built_in(), data.get(), DECID_ALL, &found, size), Code::size_mismatch,
            "a size of " + std::to_string(size));
}

}  // namespace decid
