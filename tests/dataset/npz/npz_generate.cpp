// Data sets made straight into their file: the bytes of one made in memory, whatever interrupts the work and wherever
// the unfinished file is cut or damaged; and what belongs to another request is left alone.
#include <omp.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <map>

#include "base/communicator.hpp"
#include "base/files/disk_file.hpp"
#include "base/files/sha256.hpp"
#include "dataset/npz/detail/journal.hpp"
#include "dataset/npz/npz.hpp"
#include "sim/protocol/protocol_json.hpp"
#include "tests/helpers.hpp"
#include "tests/sim/tiny_protocol.hpp"

using namespace decid;
using namespace decid::dataset;
using namespace decid::test;

namespace {

namespace fs = std::filesystem;

constexpr const char* program = "decid test";

/// Two chunks of base trials and one of children at least.
DatasetRequest request() {
  DatasetRequest wanted{tiny_protocol(), 1300, 1150, 3};
  wanted.protocol.noise.sensor = {0.001, 0.1};
  return wanted;
}

std::string hash_values(const fs::path& path) {
  return sha256(read_text(path));
}

const std::string& expected_hash() {
  static const std::string hash = [] {
    const TemporaryFolder folder;
    write_npz(folder / "a.npz", generate(request()));
    return hash_values(folder / "a.npz");
  }();
  return hash;
}

/// Returns where the entries of a journal begin, behind its request.
std::vector<std::size_t> entries_of(const std::string& journal) {
  std::vector<std::size_t> places;
  for (std::size_t at = journal.find('\n') + 1; at + 72 <= journal.size();) {
    places.push_back(at);
    std::uint64_t size = 0;
    std::memcpy(&size, journal.data() + at, sizeof size);
    at += 72 + static_cast<std::size_t>(size);
  }
  places.erase(places.begin());
  return places;
}

/// State on disk after a run was stopped at a given number of progress reports.
struct Stopped {
  TemporaryFolder folder;
  fs::path path = folder / "a.npz";
  NpzPartial partial = npz_partial(path);
  int trials = 0;

  explicit Stopped(int reports) {
    check_error(
        [&] {
          generate_npz(path, request(), program, [&](int done, int) {
            trials = done;
            return --reports > 0;
          });
        },
        Code::stopped, "1300 trials");
    CHECK_FALSE(fs::exists(path));
    CHECK(folder.files() == 2);
  }
};

/// Goes on and checks the bytes; returns where it went on, 0 if from the start.
int go_on(const fs::path& path) {
  int resumed = 0, first = -1;
  generate_npz(
      path, request(), program,
      [&](int done, int) {
        if (first < 0) first = done;
        return true;
      },
      [&](int trials) { resumed = trials; });
  CHECK(hash_values(path) == expected_hash());
  CHECK_FALSE(fs::exists(npz_partial(path).file));
  CHECK_FALSE(fs::exists(npz_partial(path).journal));
  return resumed;
}

/// Rank 1 of 2, whose rank 0 broadcasts these texts and gathers empty ones, as often as two gather_texts() do.
class SecondRank final : public Communicator {
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

 private:
  std::string bytes_;
  std::size_t at_ = 0;
  int gathered_ = 0;
};

/// A single rank whose network fails after some gathers.
class FailingNetwork final : public Communicator {
 public:
  explicit FailingNetwork(int gathers) : gathers_(gathers) {}
  int rank() const override { return 0; }
  int size() const override { return 1; }
  void broadcast(std::span<std::byte>) override {}
  void all_gather(std::span<const std::byte> own, std::span<const std::size_t>, std::span<std::byte> all) override {
    if (gathers_-- == 0) throw Error(Code::system_failed, "network", "failed", "run the same command again");
    std::ranges::copy(own, all.begin());
  }
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

 private:
  int gathers_;
};

}  // namespace

TEST_CASE("a data set made into its file is the one made in memory, for any number of threads") {
  const TemporaryFolder folder;
  const int before = omp_get_max_threads();
  DatasetReport in_memory;
  generate(request(), &in_memory);
  for (const int threads : {1, 2, 3}) {
    CAPTURE(threads);
    omp_set_num_threads(threads);
    int last = 0;
    const DatasetReport report = generate_npz(folder / "a.npz", request(), program, [&](int done, int total) {
      CHECK(done >= last);
      CHECK(total == 1300);
      last = done;
      return true;
    });
    CHECK(last == 1300);
    CHECK(hash_values(folder / "a.npz") == expected_hash());
    CHECK(report.base_attempts == in_memory.base_attempts);
    CHECK(report.child_attempts == in_memory.child_attempts);
    CHECK(report.parents == in_memory.parents);
    CHECK(report.all.peak_to_peak.mean() == in_memory.all.peak_to_peak.mean());
  }
  omp_set_num_threads(before);
  CHECK(folder.files() == 1);
  CHECK(near(static_cast<double>(npz_bytes(1300, request().protocol)),
             static_cast<double>(fs::file_size(folder / "a.npz")), 0.005));
}

TEST_CASE("a stopped data set goes on where it stopped, more than once, with the same report") {
  const Stopped stopped(1);
  CHECK(stopped.trials > 300);
  // Stopped again, a chunk further: the first report is that of what is there.
  int reports = 0;
  int resumed = 0;
  check_error(
      [&] {
        generate_npz(
            stopped.path, request(), program, [&](int, int) { return ++reports < 2; },
            [&](int trials) { resumed = trials; });
      },
      Code::stopped);
  CHECK(resumed == stopped.trials);
  DatasetReport whole;
  generate(request(), &whole);
  const DatasetReport report = generate_npz(stopped.path, request(), program);
  CHECK(hash_values(stopped.path) == expected_hash());
  CHECK(report.base_attempts == whole.base_attempts);
  CHECK(report.child_attempts == whole.child_attempts);
  CHECK(report.parents == whole.parents);
  for (std::size_t i = 0; i < sim::single_pendulum().parameters.size(); ++i) {
    CHECK(report.base.parameters[i].mean() == whole.base.parameters[i].mean());
    CHECK(report.all.parameters[i].stddev() == whole.all.parameters[i].stddev());
  }
}

TEST_CASE("an unfinished file that is cut off anywhere goes on from its last sound chunk") {
  const Stopped stopped(3);
  const std::string file = read_text(stopped.partial.file), journal = read_text(stopped.partial.journal);
  const std::size_t trial = 400 * sizeof(float), start = 64 + 128;
  REQUIRE(file.size() == start + static_cast<std::size_t>(stopped.trials) * trial);
  std::map<int, int> seen;
  const auto try_with = [&](const std::string& file_left, const std::string& journal_left) {
    write_text(stopped.partial.file, file_left);
    write_text(stopped.partial.journal, journal_left);
    ++seen[go_on(stopped.path)];
  };
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{40}, start - 1, start, start + trial / 2,
                                 file.size() / 2, file.size() - trial, file.size() - 1, file.size()}) {
    CAPTURE(size);
    try_with(file.substr(0, size), journal);
  }
  const std::size_t entry = entries_of(journal).at(0), last = entries_of(journal).back();
  REQUIRE(last > entry);
  for (const std::size_t size :
       {entry, entry + 3, entry + 40, entry + 41, last - 1, last, last + 39, last + 40 + 72, journal.size() - 1}) {
    CAPTURE(size);
    try_with(file, journal.substr(0, size));
  }
  // Longer than it should be, as after a failure while the last arrays were written; and both at once.
  try_with(file + std::string(5000, 'x'), journal + std::string(100, 'x'));
  try_with(file.substr(0, file.size() / 2), journal.substr(0, last + 5));
  // From the start, from each of the chunks, and from where it stopped.
  CHECK(seen.size() == 4);
  CHECK(seen.contains(0));
  CHECK(seen.contains(stopped.trials));
}

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

TEST_CASE("an impossible request does not remove files that another call began") {
  const TemporaryFolder folder;
  DatasetRequest quiet{tiny_protocol(), 1300, 1150, 3};
  quiet.protocol.sequence().amplitude_deg = 0.01;
  quiet.protocol.noise.vestibular.scale_deg = 0.0;
  check_error([&] { generate_npz(folder / "a.npz", quiet, program, [](int, int) { return false; }); }, Code::stopped);
  check_error([&] { generate_npz(folder / "a.npz", quiet, program); }, Code::trials_missing);
  CHECK(folder.files() == 2);
}

TEST_CASE("damaged bytes of an unfinished file are made again") {
  const Stopped stopped(3);
  const std::string file = read_text(stopped.partial.file), journal = read_text(stopped.partial.journal);
  const auto flipped = [](std::string text, std::size_t position) {
    text[position] = static_cast<char>(text[position] ^ 0x10);
    return text;
  };
  for (const std::size_t position :
       {std::size_t{3}, std::size_t{15}, std::size_t{100}, std::size_t{64 + 128}, file.size() / 3, file.size() - 1}) {
    CAPTURE(position);
    write_text(stopped.partial.file, flipped(file, position));
    write_text(stopped.partial.journal, journal);
    const int resumed = go_on(stopped.path);
    CHECK((resumed < stopped.trials) ==
          (position >= 64 + 128));  // a resumed run writes the arrays before the sway again
  }
  const std::size_t entry = entries_of(journal).at(0), last = entries_of(journal).back();
  for (const std::size_t position :
       {entry, entry + 4, entry + 8, entry + 16, entry + 32, entry + 36, entry + 50, last + 2, journal.size() - 1}) {
    CAPTURE(position);
    write_text(stopped.partial.file, file);
    write_text(stopped.partial.journal, flipped(journal, position));
    CHECK(go_on(stopped.path) < stopped.trials);
  }
}

TEST_CASE("an unfinished file of another request is refused and left as it is") {
  const Stopped stopped(1);
  const std::string file = read_text(stopped.partial.file), journal = read_text(stopped.partial.journal);
  const auto refused = [&](DatasetRequest other, const char* name, Code code, std::string_view fact = {}) {
    check_error([&] { generate_npz(stopped.path, other, name); }, code, fact);
    CHECK(read_text(stopped.partial.file) == file);
    CHECK(read_text(stopped.partial.journal) == journal);
  };
  DatasetRequest other = request();
  other.seed = 4;
  refused(other, program, Code::file_differs, "seed 3, not 4");
  other = request();
  other.count = 1301;
  refused(other, program, Code::file_differs, "1300");
  other.base = 0;
  refused(other, program, Code::file_differs, "1150");
  other = request();
  other.protocol.noise.sensor = {0.001, 0.2};
  refused(other, program, Code::file_differs);
  refused(request(), "decid other", Code::file_differs);
  // Without the journal the file's contents are unknown.
  for (const std::size_t size : {std::size_t{0}, std::size_t{10}, std::size_t{30}}) {
    write_text(stopped.partial.journal, journal.substr(0, size));
    check_error([&] { generate_npz(stopped.path, request(), program); }, Code::file_damaged, "a.npz.partial");
    CHECK(read_text(stopped.partial.file) == file);
  }
  // A journal alone holds nothing of worth.
  write_text(stopped.partial.journal, journal);
  fs::remove(stopped.partial.file);
  other = request();
  other.seed = 5;
  generate_npz(stopped.path, other, program);
  CHECK(stopped.folder.files() == 1);
}

TEST_CASE("base 0 and base = count are the same request") {
  const TemporaryFolder folder;
  DatasetRequest wanted{tiny_protocol(), 1100, 0, 3};
  check_error([&] { generate_npz(folder / "a.npz", wanted, program, [](int, int) { return false; }); }, Code::stopped);
  wanted.base = 1100;
  int resumed = 0;
  generate_npz(folder / "a.npz", wanted, program, {}, [&](int trials) { resumed = trials; });
  CHECK(resumed > 0);
}

TEST_CASE("a full disk stops the work and keeps the finished part") {
  const Stopped reference(3);
  const TemporaryFolder folder;
  rlimit before{};
  REQUIRE(getrlimit(RLIMIT_FSIZE, &before) == 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit tight = before;
  int resumed = -1, last = 0;
  for (const rlim_t limit : {rlim_t{50}, rlim_t{100'000}, rlim_t{1'700'000}, rlim_t{2'080'200}}) {
    CAPTURE(limit);
    tight.rlim_cur = limit;  // a limit on the size of files stands for a full disk
    REQUIRE(setrlimit(RLIMIT_FSIZE, &tight) == 0);
    resumed = 0;
    const std::string message = message_of(
        [&] { generate_npz(folder / "a.npz", request(), program, {}, [&](int trials) { resumed = trials; }); });
    REQUIRE(setrlimit(RLIMIT_FSIZE, &before) == 0);
    CHECK(contains(message, "a.npz.partial"));
    CHECK(contains(message, "cannot be written: "));
    CHECK(contains(message, "same command again"));
    CHECK(fs::exists(folder / "a.npz.partial"));
    CHECK_FALSE(fs::exists(folder / "a.npz"));
    CHECK(resumed >= last);
    last = resumed;
  }
  std::signal(SIGXFSZ, handler);
  CHECK(go_on(folder / "a.npz") > 0);
}

TEST_CASE("one process at a time") {
  const Stopped stopped(1);
  {
    DiskFile other(stopped.partial.file, DiskFile::Access::write);
    REQUIRE(other.try_lock());
    check_error([&] { generate_npz(stopped.path, request(), program); }, Code::file_in_use, "a.npz.partial");
  }
  CHECK(go_on(stopped.path) == stopped.trials);
}

TEST_CASE("outputs that cannot be, and requests that cannot be met, leave nothing behind") {
  const TemporaryFolder folder;
  const DatasetRequest wanted{tiny_protocol(), 10, 5, 3};
  check_error([&] { generate_npz(folder / "no" / "a.npz", wanted, program); }, Code::file_unwritable);
  check_error([&] { generate_npz(folder.path(), wanted, program); }, Code::file_unwritable);
  check_error([&] { generate_npz("/dev/null", wanted, program); }, Code::file_unwritable, "/dev/null");
  DatasetRequest quiet = wanted;
  quiet.protocol.sequence().amplitude_deg = 0.01;
  quiet.protocol.noise.vestibular.scale_deg = 0.0;
  check_error([&] { generate_npz(folder / "a.npz", quiet, program); }, Code::trials_missing, "5 base");
  DatasetRequest none = wanted;
  none.count = 0;
  check_error([&] { generate_npz(folder / "a.npz", none, program); }, Code::setting_out_of_range, "at least 1");
  CHECK(folder.files() == 0);
}

TEST_CASE("the output replaces an older file, with its permissions and through a link") {
  const TemporaryFolder folder;
  write_text(folder / "b.npz", "old");
  fs::permissions(folder / "b.npz", fs::perms::owner_read | fs::perms::owner_write);
  fs::create_symlink("b.npz", folder / "a.npz");
  CHECK(npz_partial(folder / "a.npz").file.filename() == "b.npz.partial");
  generate_npz(folder / "a.npz", request(), program);
  CHECK(fs::is_symlink(folder / "a.npz"));
  CHECK(hash_values(folder / "b.npz") == expected_hash());
  CHECK(fs::status(folder / "b.npz").permissions() == (fs::perms::owner_read | fs::perms::owner_write));
}

TEST_CASE("a stored data set reads its sway from the file") {
  const TemporaryFolder folder;
  const Dataset data = generate({tiny_protocol(), 40, 30, 3});
  write_npz(folder / "a.npz", data);
  const StoredDataset stored(folder / "a.npz"), in_memory(data);
  CHECK_FALSE(stored.in_memory());
  CHECK(in_memory.in_memory());
  CHECK(stored.about().sway.empty());
  CHECK(stored.about().parameters == data.parameters);
  CHECK(stored.about().group == data.group);
  CHECK(stored.about().split == data.split);
  CHECK(stored.about().samples == 400);
  CHECK(to_json(stored.about().protocol) == to_json(data.protocol));
  std::vector<float> a(400), b(400);
  for (const int i : {0, 17, 39}) {
    stored.read(i, a);
    in_memory.read(i, b);
    CHECK(std::equal(a.begin(), a.end(), data.trial(i).begin()));
    CHECK(a == b);
  }
  for (const StoredDataset* data_set : {&stored, &in_memory}) {
    std::vector<std::vector<float>> taken(3);
    const auto keep = [&](std::size_t place, std::span<const float> sway) {
      taken[place].assign(sway.begin(), sway.end());
    };
    const auto expected = [&](int trial) {
      return std::vector<float>(data.trial(trial).begin(), data.trial(trial).end());
    };
    data_set->take(37, 3, keep);
    for (const int i : {0, 1, 2}) CHECK(taken[static_cast<std::size_t>(i)] == expected(37 + i));
    data_set->take(std::vector<int>{5, 0, 39}, keep);
    CHECK(taken == std::vector<std::vector<float>>{expected(5), expected(0), expected(39)});
    check_error([&] { data_set->take(38, 3, keep); }, Code::setting_out_of_range);
    for (const int i : {-1, 40}) check_error([&] { data_set->read(i, a); }, Code::setting_out_of_range, "0 to");
    std::vector<float> wrong(399);
    check_error([&] { data_set->read(0, wrong); }, Code::size_mismatch, "399 samples");
    wrong.resize(401);
    check_error([&] { data_set->read(0, wrong); }, Code::size_mismatch, "401 samples");
  }
  // The members in another order: into memory.
  const std::string script =
      "import sys, numpy as np\nd = dict(np.load(sys.argv[1]))\n"
      "np.savez(sys.argv[2], group=d['group'], **{k: d[k] for k in d if k != 'group'})\n";
  write_text(folder / "save.py", script);
  if (std::system("/usr/bin/python3 -c 'import numpy' 2>/dev/null") == 0) {
    const std::string command = "/usr/bin/python3 " + (folder / "save.py").string() + " " +
                                (folder / "a.npz").string() + " " + (folder / "b.npz").string();
    REQUIRE(std::system(command.c_str()) == 0);
    const StoredDataset other(folder / "b.npz");
    CHECK(other.in_memory());
    CHECK(other.about().sway == data.sway);
  }
  // Damage: a bit that only the checksum shows, an invalid value, and an end that is cut off while in use.
  std::string content = read_text(folder / "a.npz");
  content[1000] = static_cast<char>(content[1000] ^ 1);
  write_text(folder / "c.npz", content);
  check_error([&] { StoredDataset(folder / "c.npz"); }, Code::file_damaged, "c.npz");
  content.replace(1000, 4, std::string("\x00\x00\xc0\x7f", 4));
  write_text(folder / "c.npz", content);
  check_error([&] { StoredDataset(folder / "c.npz"); }, Code::file_damaged, "sway of trial 0");
  fs::resize_file(folder / "a.npz", 3000);
  check_error([&] { stored.read(39, a); }, Code::file_damaged, "a.npz");
}

TEST_CASE("a journal holds as many parameters as a trial has") {
  const TemporaryFolder folder;
  for (const std::size_t parameters : {std::size_t{7}, std::size_t{14}, sim::Parameters::most}) {
    const fs::path path = folder / std::to_string(parameters).c_str();
    JournalEntry entry;
    entry.sway_crc32 = 0x12345678;
    entry.chunk.base_attempts = 9;
    entry.chunk.child_attempts = 4;
    for (std::int32_t i = 0; i < 3; ++i) {
      TrialRecord trial{sim::Parameters(parameters), 0.01 * i, i % 2};
      for (std::size_t p = 0; p < parameters; ++p) trial.parameters[p] = 1.0 / (1.0 + static_cast<double>(p) + i);
      entry.chunk.trials.push_back(trial);
    }
    {
      ChunkJournal journal(path);
      journal.start("request");
      journal.append(entry, 0);
      journal.append(entry, 3);
    }
    ChunkJournal journal(path);
    REQUIRE(journal.request() == "request");
    // The name, the text, and two entries of three trials; 72 bytes in front of each.
    CHECK(fs::file_size(path) == 16 + 72 + 7 + 2 * (72 + 36 + 3 * (8 * parameters + 20)));
    for (const int before : {0, 3}) {
      const std::optional<JournalEntry> read = journal.next(before);
      REQUIRE(read);
      CHECK(read->sway_crc32 == entry.sway_crc32);
      CHECK(read->chunk.base_attempts == 9);
      CHECK(read->chunk.child_attempts == 4);
      REQUIRE(read->chunk.trials.size() == 3);
      for (std::size_t i = 0; i < 3; ++i) {
        CHECK(read->chunk.trials[i].parameters == entry.chunk.trials[i].parameters);
        CHECK(read->chunk.trials[i].peak_to_peak_rad == entry.chunk.trials[i].peak_to_peak_rad);
        CHECK(read->chunk.trials[i].group == entry.chunk.trials[i].group);
      }
    }
    CHECK_FALSE(journal.next(6));
    journal.back();
    CHECK_FALSE(journal.next(0));
    CHECK(journal.next(3));
  }
}
