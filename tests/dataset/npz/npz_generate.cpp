// Data sets made straight into their file: the bytes of one made in memory, whatever interrupts the work and wherever
// the unfinished file is cut or damaged; and what belongs to another request is left alone.
#include <omp.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#include <cstring>
#include <map>

#include "base/files/disk_file.hpp"
#include "base/files/sha256.hpp"
#include "dataset/npz/npz.hpp"
#include "tests/dataset/npz/unfinished.hpp"

using namespace decid;
using namespace decid::dataset;
using namespace decid::test;

namespace {

namespace fs = std::filesystem;

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

TEST_CASE("an unfinished file that is cut off or damaged anywhere goes on from its last sound chunk") {
  const Stopped stopped(3);
  const std::string file = read_text(stopped.partial.file), journal = read_text(stopped.partial.journal);
  const std::size_t trial = 400 * sizeof(float), start = 64 + 128;
  REQUIRE(file.size() == start + static_cast<std::size_t>(stopped.trials) * trial);
  std::map<int, int> seen;
  const auto try_with = [&](const std::string& file_left, const std::string& journal_left) {
    write_text(stopped.partial.file, file_left);
    write_text(stopped.partial.journal, journal_left);
    const int resumed = go_on(stopped.path);
    ++seen[resumed];
    return resumed;
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
  const auto flipped = [](std::string text, std::size_t position) {
    text[position] = static_cast<char>(text[position] ^ 0x10);
    return text;
  };
  for (const std::size_t position :
       {std::size_t{3}, std::size_t{15}, std::size_t{100}, start, file.size() / 3, file.size() - 1}) {
    CAPTURE(position);
    // A resumed run writes the arrays before the sway again.
    CHECK((try_with(flipped(file, position), journal) < stopped.trials) == (position >= start));
  }
  for (const std::size_t position :
       {entry, entry + 4, entry + 8, entry + 16, entry + 32, entry + 36, entry + 50, last + 2, journal.size() - 1}) {
    CAPTURE(position);
    CHECK(try_with(file, flipped(journal, position)) < stopped.trials);
  }
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
  // Another program's file of the journal's name is not decid's to empty.
  fs::remove(stopped.partial.file);
  write_text(stopped.partial.journal, "a diary");
  check_error([&] { generate_npz(stopped.path, request(), program); }, Code::file_unsupported, "a.npz.partial.journal");
  CHECK(read_text(stopped.partial.journal) == "a diary");
  CHECK_FALSE(fs::exists(stopped.partial.file));
  // A journal alone holds nothing of worth.
  write_text(stopped.partial.journal, journal);
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
