// decid selftest: checks that this machine, or several machines alone and together, compute the expected bits. The
// first two figures are those of docs/develop/determinism.md.
#include <algorithm>
#include <chrono>
#include <iostream>
#include <memory>

#include "base/error.hpp"
#include "base/files/json_object.hpp"
#include "base/isa.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "identify/evaluation/self_checks.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/ranks.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/report/json/recording_json.hpp"

namespace decid::tools {
namespace {

struct SelftestOptions {
  CommonOptions common;
  bool mpi = false;
};

/// One check at one rank, or of all ranks together.
struct SelfResult {
  std::string check, of, sha256, expected;
  bool ok() const { return sha256 == expected; }
};

/// The hashes that a rank computed alone.
struct OwnHashes {
  std::string kernels;
  int threads = 0;
  std::vector<std::string> by_check;

  template <class Archive>
  void archive(Archive& a) {
    a(kernels, threads, by_check);
  }
};

void run_selftest(const SelftestOptions& options, const Command& command) {
  if (options.mpi && ranks() == nullptr)
    throw Error(Code::not_supported, "--mpi", "needs several processes, but there is only one",
                "start it with mpirun or srun, and a decid that was built with -DDECID_MPI=ON");
  const auto start = std::chrono::steady_clock::now();
  const std::vector<SelfCheck> checks = self_checks();
  OwnHashes own{name(chosen_isa()), thread_count(), {}};
  for (const SelfCheck& check : checks) own.by_check.push_back(check.compute(nullptr));
  const std::vector<OwnHashes> all = gather_values(own);
  std::vector<SelfResult> results;
  for (std::size_t r = 0; r < all.size(); ++r)
    for (std::size_t i = 0; i < checks.size(); ++i)
      results.push_back(
          {checks[i].name,
           format("rank %zu, %s, %s", r, all[r].kernels.c_str(), counted(all[r].threads, "thread").c_str()),
           all[r].by_check.at(i), checks[i].expected});
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
    Json json{{"ok", wrong == 0}, {"checks", list}};
    add_call(json, record_call(command, {}));
    std::cout << print_json(json) << '\n';
  } else {
    for (const SelfResult& result : results)
      std::cout << format("%-7s %-30s %s", result.ok() ? "ok" : "WRONG", result.check.c_str(), result.of.c_str())
                << (result.ok() ? "\n" : ": SHA-256 " + result.sha256 + ", not " + result.expected + "\n");
    std::cout << format("%zu of %zu have the expected bits, in %.1f s\n",
                        results.size() - static_cast<std::size_t>(wrong), results.size(), seconds);
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
  command.add_flag("--mpi", options->mpi, "Fail unless several MPI processes run").section("Advanced");
  command.footer(
      "Examples:\n"
      "  decid selftest\n"
      "  decid selftest --json\n"
      "  mpirun -n 8 decid selftest --mpi");
  run_with(command, options, true, run_selftest);
}

}  // namespace decid::tools
