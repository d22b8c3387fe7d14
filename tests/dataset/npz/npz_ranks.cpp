// Data sets that several processes make: a rank that sees another journal, and a network that fails.
#include <sys/stat.h>

#include <algorithm>
#include <cstring>

#include "base/communicator.hpp"
#include "tests/dataset/npz/unfinished.hpp"

using namespace decid;
using namespace decid::dataset;
using namespace decid::test;

namespace fs = std::filesystem;

namespace {

/// A rank that exchanges and sends nothing.
class SilentRank : public Communicator {
 public:
  std::unique_ptr<Transfer> start_exchange(std::span<const std::byte>, std::span<const std::size_t>,
                                           std::span<std::byte>, std::span<const std::size_t>) override {
    return nullptr;
  }
  std::unique_ptr<Transfer> start_all_gather(std::span<const std::byte>, std::span<const std::size_t>,
                                             std::span<std::byte>) override {
    return nullptr;
  }
  void send(int, const std::string&) override {}
  std::optional<Message> poll() override { return std::nullopt; }
};

/// Rank 1 of 2, whose rank 0 broadcasts these texts and gathers empty ones, as often as two gather_texts() do.
class SecondRank final : public SilentRank {
 public:
  explicit SecondRank(const std::vector<std::string>& texts) {
    for (const std::string& text : texts) {
      const std::uint64_t size = text.size();
      bytes_.append(reinterpret_cast<const char*>(&size), sizeof size);
      bytes_ += text;
    }
  }
  int rank() const override { return 1; }
  int size() const override { return 2; }
  void broadcast(std::span<std::byte> bytes) override {
    REQUIRE(at_ + bytes.size() <= bytes_.size());
    std::memcpy(bytes.data(), bytes_.data() + at_, bytes.size());
    at_ += bytes.size();
  }
  void all_gather(std::span<const std::byte>, std::span<const std::size_t>, std::span<std::byte> all) override {
    if (++gathered_ > 4) throw Error(Code::stopped, "gather", "was called again", "stop");
    std::ranges::fill(all, std::byte{});
  }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
  int gathered_ = 0;
};

/// A single rank whose network fails after some gathers.
class FailingNetwork final : public SilentRank {
 public:
  explicit FailingNetwork(int gathers) : gathers_(gathers) {}
  int rank() const override { return 0; }
  int size() const override { return 1; }
  void broadcast(std::span<std::byte>) override {}
  void all_gather(std::span<const std::byte> own, std::span<const std::size_t>, std::span<std::byte> all) override {
    if (gathers_-- == 0) throw Error(Code::system_failed, "network", "failed", "run the same command again");
    std::ranges::copy(own, all.begin());
  }

 private:
  int gathers_;
};

}  // namespace

TEST_CASE("a process that sees a shorter journal than rank 0 stops") {
  const Stopped stopped(1);
  struct stat status {};
  REQUIRE(::stat(stopped.partial.file.c_str(), &status) == 0);
  const std::string identity = std::to_string(status.st_ino) + " " + std::to_string(status.st_size);
  const auto with_trials_of_rank_0 = [&](int trials) {
    SecondRank rank({identity, std::to_string(trials)});
    generate_npz(stopped.path, request(), program, {}, {}, &rank);
  };
  check_error([&] { with_trials_of_rank_0(1300); }, Code::system_failed, "1300");
  check_error([&] { with_trials_of_rank_0(stopped.trials); }, Code::stopped);  // goes on
}

TEST_CASE("a network that fails leaves the unfinished files, and the same request continues") {
  const TemporaryFolder folder;
  const fs::path path = folder / "a.npz";
  // Four gathers before the first chunk; then the attempts of three chunks, and the checksums of the first.
  for (const int gathers : {5, 7}) {
    FailingNetwork network(gathers);
    check_error([&] { generate_npz(path, request(), program, {}, {}, &network); }, Code::system_failed);
    CHECK(folder.files() == 2);
  }
  CHECK(go_on(path) > 300);
}
