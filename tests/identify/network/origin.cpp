// Where models come from: read back as written, version 1 too, and trials that a model was trained on refused.
#include "identify/network/origin.hpp"

#include "base/error.hpp"
#include "dataset/sets/dataset.hpp"
#include "identify/network/model.hpp"
#include "tests/helpers.hpp"

namespace decid {
namespace {

using namespace test;
using Kind = dataset::TrialIdentity::Kind;

Origin origin() {
  Origin made;
  made.program = "decid 9.9.9";
  made.preset = "best";
  made.seed = 18446744073709551615U;
  made.epochs = 3;
  made.batch = 64;
  made.learning_rate = 0.05;
  made.momentum = 0.9;
  made.weight_decay = 1e-4;
  made.schedule = "cosine";
  made.warmup_epochs = 1;
  made.architecture = "fc 3\nfc 7";
  made.trials = {Kind::stream, 7, {}};
  made.training_trials = 25600;
  made.validation_trials = 1000;
  return made;
}

}  // namespace

TEST_CASE("origin: JSON gives the same origin") {
  Origin made = origin();
  CHECK(origin_from_json(to_json(made), "m") == made);
  made.trials = {Kind::stored, 12, "abcdef"};
  made.patience = 20;
  made.average = 0.99;
  CHECK(origin_from_json(to_json(made), "m") == made);
  CHECK(contains(to_json(made), "\"patience\":20"));
  CHECK(contains(to_json(made), "\"average\":0.99"));
  for (const char* left_out : {"patience", "average"}) CHECK_FALSE(contains(to_json(origin()), left_out));
  CHECK_FALSE(contains(to_json(made), "\n"));
}

TEST_CASE("origin: each setting that differs makes another origin, and is named") {
  const Origin same = origin();
  CHECK(difference(same, origin()).empty());
  struct Change {
    const char* named;
    void (*make)(Origin&);
  };
  for (const Change& change :
       {Change{"preset", [](Origin& o) { o.preset = "series"; }}, Change{"seed", [](Origin& o) { o.seed = 2; }},
        Change{"epochs", [](Origin& o) { o.epochs = 4; }}, Change{"batch", [](Origin& o) { o.batch = 32; }},
        Change{"learning_rate", [](Origin& o) { o.learning_rate = 0.1; }},
        Change{"momentum", [](Origin& o) { o.momentum = 0.5; }},
        Change{"weight_decay", [](Origin& o) { o.weight_decay = 0.0; }},
        Change{"schedule", [](Origin& o) { o.schedule = "step"; }},
        Change{"warmup_epochs", [](Origin& o) { o.warmup_epochs = 2; }},
        Change{"architecture", [](Origin& o) { o.architecture = "fc 7"; }},
        Change{"trials", [](Origin& o) { o.trials.seed = 8; }},
        Change{"training_trials", [](Origin& o) { o.training_trials = 1; }},
        Change{"validation_trials", [](Origin& o) { o.validation_trials = 1; }},
        Change{"average", [](Origin& o) { o.average = 0.5; }}, Change{"patience", [](Origin& o) { o.patience = 9; }}}) {
    INFO(std::string(change.named));
    Origin other = origin();
    change.make(other);
    CHECK(other != same);
    CHECK(test::contains(difference(same, other), change.named));
  }
  Origin longer = origin(), tuned = origin();
  longer.extensions = {{1, 2}};
  tuned.from = Origin::Start{"ab", {}};
  CHECK(longer != same);
  CHECK(tuned != same);
}

TEST_CASE("origin: a fine tuning names what it began with, a longer training where it went on") {
  Origin made = origin();
  CHECK_FALSE(contains(to_json(made), "extensions"));
  CHECK_FALSE(contains(to_json(made), "from"));
  made.extensions = {{3, 3}, {5, 9}};
  const Origin::Start start = start_from(origin(), "ab");
  CHECK(start.weights_sha256 == "ab");
  CHECK(start.trials == std::vector{origin().trials});
  made.from = start;
  CHECK(origin_from_json(to_json(made), "m") == made);
  // The trials of all models before it.
  made.trials = {Kind::stored, 99, "dd"};
  CHECK(start_from(made, "cd").trials == std::vector{made.trials, origin().trials});
  check_error(
      [&] {
        require_not_trained_on(made, {Kind::stored, 7, "zz"}, Measured::all, "d.npz");
      },
      Code::data_reused, "seed 7");
  made.from->trials = {{Kind::stored, {}, "aa"}};
  check_error(
      [&] {
        require_not_trained_on(made, {Kind::stored, {}, "aa"}, Measured::all, "d.npz");
      },
      Code::data_reused, "d.npz");
  require_not_trained_on(made, {Kind::stored, {}, "bb"}, Measured::all, "d.npz");
  CHECK(origin_from_json(R"({"from":3,"extensions":{}})", "m").extensions.empty());
}

TEST_CASE("origin: version 1 named its trials in a sentence") {
  const Origin stream = origin_from_json(
      R"({"program":"decid 0.1.0","preset":"best","seed":1,"trials":"simulated for each epoch from seed 41"})", "m");
  CHECK(stream.version == 1);
  CHECK(stream.preset == "best");
  CHECK(stream.trials == dataset::TrialIdentity{Kind::stream, 41, {}});
  const Origin stored = origin_from_json(R"({"trials":"data set 00ff"})", "m");
  CHECK(stored.trials == dataset::TrialIdentity{Kind::stored, {}, "00ff"});
  CHECK(origin_from_json(R"({"trials":"a basket"})", "m").trials.kind == Kind::unknown);
  CHECK(origin_from_json(R"({"trials":"simulated for each epoch from seed ?"})", "m").trials.kind == Kind::unknown);
  CHECK(origin_from_json("{}", "m").trials.kind == Kind::unknown);
  CHECK(origin_from_json(R"({"epochs":"many","seed":[1]})", "m").epochs == 0);
  check_error([] { origin_from_json("[1]", "m.safetensors"); }, Code::file_damaged, "m.safetensors");
  check_error([] { origin_from_json("{", "m.safetensors"); }, Code::setting_malformed, "m.safetensors");
  // The built-in model is of that version.
  CHECK(built_in_model().origin.trials == dataset::TrialIdentity{Kind::stream, 1, {}});
}

TEST_CASE("origin: nobody measures a model on its training") {
  const dataset::TrialIdentity same_seed{Kind::stored, 7, "aa"}, other_seed{Kind::stored, 8, "aa"};
  check_error([&] { require_not_trained_on(origin(), same_seed, Measured::all, "d.npz"); }, Code::data_reused,
              "seed 7");
  check_error([&] { require_not_trained_on(origin(), same_seed, Measured::validation, "d.npz"); }, Code::data_reused,
              "seed 7");
  require_not_trained_on(origin(), other_seed, Measured::all, "d.npz");
  // Unknown seeds are not equal.
  require_not_trained_on(origin_from_json("{}", "m"), same_seed, Measured::all, "d.npz");

  Origin stored = origin();
  stored.trials = same_seed;
  check_error([&] { require_not_trained_on(stored, same_seed, Measured::all, "d.npz"); }, Code::data_reused, "d.npz");
  CHECK(trained_on(stored, same_seed));
  CHECK_FALSE(trained_on(origin(), same_seed));
  require_not_trained_on(stored, same_seed, Measured::validation, "d.npz");
  require_not_trained_on(stored, same_seed, Measured::training, "d.npz");
  // A larger set of the same seed begins with the same trials.
  check_error(
      [&] {
        require_not_trained_on(stored, {Kind::stored, 7, "bb"}, Measured::all, "d.npz");
      },
      Code::data_reused, "seed 7");
  require_not_trained_on(stored, {Kind::stored, 9, "cc"}, Measured::all, "d.npz");
}

TEST_CASE("origin: data sets are known by their trials") {
  const auto identity = [](std::uint64_t seed) {
    return dataset::trial_identity(dataset::generate({.protocol = sim::short_protocol(), .count = 4, .seed = seed}));
  };
  CHECK(identity(3) == identity(3));
  CHECK(identity(3).sha256 != identity(4).sha256);
  CHECK(identity(3).seed == 3);
}

}  // namespace decid
