// decid selftest: checks that this machine, or several machines alone and together, compute the expected bits. The
// first two figures are those of docs/develop/determinism.md.
#include <algorithm>
#include <chrono>
#include <functional>
#include <iostream>
#include <memory>

#include "base/error.hpp"
#include "base/files/json_object.hpp"
#include "base/files/sha256.hpp"
#include "base/isa.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "identify/training/training.hpp"
#include "nn/training/loss.hpp"
#include "nn/training/schedule.hpp"
#include "nn/training/trainer.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/ranks.hpp"

namespace decid::tools {
namespace {

struct SelftestOptions {
  CommonOptions common;
  bool mpi = false;
};

/// Returns a number from -1 to 1 that depends only on the arguments: Chris Wellons' lowbias32.
float scattered(std::uint32_t id, std::size_t index) {
  std::uint32_t h = static_cast<std::uint32_t>(index) * 0x9e3779b9U + id * 0x85ebca6bU + 0x1234567U;
  h = (h ^ (h >> 16U)) * 0x7feb352dU;
  h = (h ^ (h >> 15U)) * 0x846ca68bU;
  h ^= h >> 16U;
  return static_cast<float>(static_cast<double>(h >> 8U) * 0x1p-23 - 1.0);
}

/// Trains a small network on three means of its images, and returns the hash of its weights.
std::string steps_hash(int batch, int steps, Communicator* group) {
  constexpr nn::Shape shape{2, 12, 12};
  nn::Network<float> network(
      shape, "conv 6 3x3 pad 1; batchnorm; relu; maxpool 2; conv 8 3x3 pad 1; batchnorm; relu; avgpool 2; fc 3");
  network.initialise(1);
  nn::Trainer<float> trainer(network, batch, group);
  const std::vector<int> own = trainer.own_samples(batch);
  const auto size = static_cast<std::size_t>(shape.size());
  std::vector<float> targets, image(size);
  const nn::Schedule schedule("cosine", 0.05, steps, 10, 3);
  std::vector<double> parts(own.size() * 3);
  for (const int sample : own)
    for (std::size_t k = 0; k < 3; ++k) targets.push_back(scattered(1, 3 * static_cast<std::size_t>(sample) + k));
  for (int step = 0; step < steps; ++step) {
    for (std::size_t n = 0; n < own.size(); ++n) {
      const std::size_t first = static_cast<std::size_t>(own[n]) * size;
      for (std::size_t i = 0; i < size; ++i) image[i] = 0.5F * scattered(2, first + i) + targets[3 * n + i % 3];
      trainer.input().load(static_cast<int>(n), image);
    }
    trainer.forward();
    nn::squared_errors<float>(trainer.output(), targets, batch, parts, trainer.output_diff());
    trainer.backward();
    trainer.step(schedule.rate(step), {.momentum = 0.9, .weight_decay = 1e-4});
  }
  return nn::weights_sha256(network);
}

/// Simulated trials, images, scaling, training, validation.
std::string stream_hash(Communicator* group) {
  TrainingSettings settings;
  settings.preset = preset_named("small");
  settings.preset.epochs = 2;
  settings.seed = 5;
  settings.scaling_trials = 2000;
  settings.ranks = group;
  const auto source = dataset::stream_source(sim::default_protocol(), settings.seed, 128, 32);
  settings.preset.image = image_for(settings.preset, source->protocol());
  TrainingState state = start_training(*source, settings);
  run_training(
      *source, settings, state, [](int, int) { return true; }, [] {});
  return nn::weights_sha256(state.model.network);
}

std::string trials_hash() {
  dataset::DatasetRequest request;
  request.protocol = sim::default_protocol();
  request.protocol.noise.sensor = {0.001, 0.1};
  request.count = 32;
  const dataset::Dataset data = dataset::generate(request);
  return sha256(std::string(reinterpret_cast<const char*>(data.sway.data()), data.sway.size() * sizeof(float)));
}

struct SelfCheck {
  const char *name, *expected;
  std::function<std::string(Communicator* group)> compute;  ///< null: alone
  bool is_shared;
};

std::vector<SelfCheck> self_checks() {
  return {{"50 steps of a small network", "531d03fff66e4df54207e485c5495f27f511e7e607a2f00674e6cf666af1f30c",
           [](Communicator* group) { return steps_hash(24, 50, group); }, true},
          {"two epochs on fresh trials", "ad2a40550c932b3b6e97e1655532ca8ce4b27199ec0da89dd23d9eeafd5d0ec0",
           stream_hash, true},
          {"8 steps of 269 samples", "44ea4cf23c4181316a647f4c9ffdd471b01ee069fdf1402336cc859b417e7f79",
           [](Communicator* group) { return steps_hash(269, 8, group); }, true},
          {"32 trials with sensor noise", "cbf256c0ab11916a12a5e5fbb972b7a0d218cb6b6fcde59944bc1cb319ec641b",
           [](Communicator*) { return trials_hash(); }, false}};
}

/// One check at one rank, or of all ranks together.
struct SelfResult {
  std::string check, of, sha256, expected;
  bool ok() const { return sha256 == expected; }
};

/// Returns the results that each rank computed alone, in order of ranks: the processor's kernels, then one hash per
/// check.
std::vector<Json> gathered(const Json& own) {
  if (ranks() == nullptr) return {own};
  std::vector<Json> all;
  for (const std::string& text : gather_texts(*ranks(), own.dump())) all.push_back(parse_json(text, "selftest"));
  return all;
}

void run_selftest(const SelftestOptions& options) {
  if (options.mpi && ranks() == nullptr)
    throw Error(Code::not_supported, "--mpi", "is for several processes, and there is one",
                "start it with mpirun or srun, and a decid that was built with -DDECID_MPI=ON");
  const auto start = std::chrono::steady_clock::now();
  const std::vector<SelfCheck> checks = self_checks();
  Json own{{"kernels", name(chosen_isa())}, {"threads", thread_count()}, {"hashes", Json::array()}};
  for (const SelfCheck& check : checks) own["hashes"].push_back(check.compute(nullptr));
  const std::vector<Json> all = gathered(own);
  std::vector<SelfResult> results;
  for (std::size_t r = 0; r < all.size(); ++r)
    for (std::size_t i = 0; i < checks.size(); ++i)
      results.push_back({checks[i].name,
                         format("rank %zu, %s, %s", r, all[r].at("kernels").get<std::string>().c_str(),
                                counted(all[r].at("threads").get<int>(), "thread").c_str()),
                         all[r].at("hashes").at(i).get<std::string>(), checks[i].expected});
  if (ranks() != nullptr)
    for (const SelfCheck& check : checks)
      if (check.is_shared)
        results.push_back(
            {check.name, format("%d ranks together", ranks()->size()), check.compute(ranks()), check.expected});
  const auto wrong = std::ranges::count_if(results, [](const SelfResult& result) { return !result.ok(); });
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (options.common.json) {
    Json list = Json::array();
    for (const SelfResult& result : results)
      list.push_back({{"check", result.check},
                      {"of", result.of},
                      {"sha256", result.sha256},
                      {"expected", result.expected},
                      {"ok", result.ok()}});
    std::cout << Json{{"decid", version}, {"ok", wrong == 0}, {"checks", list}}.dump(2) << '\n';
  } else {
    for (const SelfResult& result : results)
      std::cout << format("%-7s %-30s %s", result.ok() ? "ok" : "WRONG", result.check.c_str(), result.of.c_str())
                << (result.ok() ? "\n" : ": SHA-256 " + result.sha256 + ", not " + result.expected + "\n");
    std::cout << format("%zu of %zu as they are to be, in %.1f s\n", results.size() - static_cast<std::size_t>(wrong),
                        results.size(), seconds);
  }
  if (wrong > 0)
    throw std::runtime_error("selftest: this decid does not compute the bits of decid " + std::string(version) +
                             "; look for other compiler options, or a damaged machine");
}

}  // namespace

void add_selftest(const Command& program) {
  auto options = std::make_shared<SelftestOptions>();
  const Command command =
      program.add_subcommand("selftest", "Check that this machine, or cluster, computes the expected bits");
  command.add_flag("--mpi", options->mpi, "Fail unless several MPI processes run");
  add_common_options(command, options->common, true);
  command.footer(
      "Examples:\n"
      "  decid selftest\n"
      "  decid selftest --json\n"
      "  mpirun -n 8 decid selftest --mpi");
  command.callback([options] {
    apply(options->common);
    run_selftest(*options);
  });
}

}  // namespace decid::tools
