// Processes of one call: see ranks.hpp.
#include "tools/decid/ranks.hpp"

#include <omp.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <future>
#include <iostream>
#include <memory>
#include <mutex>
#include <streambuf>
#include <thread>
#include <utility>

#include "base/error.hpp"
#include "base/files/disk_file.hpp"
#include "base/files/sha256.hpp"
#include "base/isa.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#ifdef DECID_MPI
#include "tools/mpi/world.hpp"
#endif

namespace decid::tools {
namespace {

/// Commands that all ranks work on.
constexpr const char* shared_commands[] = {"train", "dataset",   "evaluate", "identify",
                                           "fit",   "calibrate", "compare",  "selftest"};

#ifdef DECID_MPI
std::unique_ptr<mpi::World> world;
#endif

/// Discards an output.
class Nowhere : public std::streambuf {
  int overflow(int byte) override { return traits_type::not_eof(byte); }
  std::streamsize xsputn(const char*, std::streamsize count) override { return count; }
};
Nowhere nowhere;

/// Returns the size of an input file and the SHA-256 of its ends, which cover most files completely; empty for anything
/// else.
std::string digest(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return {};
  try {
    constexpr std::size_t end_bytes = std::size_t{16} << 20;
    const DiskFile file(path, DiskFile::Access::read);
    const std::uint64_t size = file.size();
    std::vector<std::byte> bytes(static_cast<std::size_t>(std::min<std::uint64_t>(size, end_bytes)));
    Sha256 hash;
    bytes.resize(file.read(0, bytes));
    hash.update(bytes.data(), bytes.size());
    if (size > end_bytes) {
      bytes.resize(file.read(size - bytes.size(), bytes));
      hash.update(bytes.data(), bytes.size());
    }
    return std::to_string(size) + " bytes, SHA-256 " + hash.hex();
  } catch (const Error& error) {
    return error.what();
  }
}

std::string host() {
  char name[256] = {};
  ::gethostname(name, sizeof(name) - 1);
  return name;
}

constexpr bool has_mpi() {
#ifdef DECID_MPI
  return true;
#else
  return false;
#endif
}

/// By mpirun or srun.
int launched_processes() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"})
    if (const char* const text = std::getenv(name)) return std::atoi(text);
  return 1;
}

}  // namespace

Communicator* ranks() {
#ifdef DECID_MPI
  return world && world->size() > 1 ? world.get() : nullptr;
#else
  return nullptr;
#endif
}

bool is_root() {
  return ranks() == nullptr || ranks()->is_root();
}

void share_processors() {
#ifdef DECID_MPI
  if (world) omp_set_num_threads(std::max(1, omp_get_max_threads() / world->sharing_processors()));
#endif
}

void require_same(const std::string& what, const std::string& text, const std::string& remedy) {
  const std::vector<std::string> all = gather_texts(ranks(), text);
  const auto other = std::ranges::find_if(all, [&](const std::string& each) { return each != all.front(); });
  if (other == all.end()) return;
  const std::vector<std::string> hosts = gather_texts(ranks(), host());
  const auto one = [&](std::size_t rank) {
    return format("rank %zu on %s has ", rank, hosts[rank].c_str()) +
           (all[rank].empty() ? "none" : one_line(all[rank]));
  };
  throw Error(Code::system_failed, what,
              "differs: " + one(0) + ", " + one(static_cast<std::size_t>(other - all.begin())), remedy);
}

std::string listed(const std::vector<std::string>& files) {
  std::string text;
  for (const std::string& file : files) {
    std::error_code error;
    const auto size = std::filesystem::file_size(file, error);
    text += file + (error ? " (not there)" : format(" (%llu bytes)", static_cast<unsigned long long>(size))) + "\n";
  }
  return text;
}

Silenced::Silenced(std::ostream& stream) : stream_(stream), before_(stream.rdbuf(&nowhere)) {}

Silenced::~Silenced() {
  stream_.rdbuf(before_);
}

Session::Session(int argc, char** argv) : argc_(argc), argv_(argv) {
#ifdef DECID_MPI
  if (!mpi::is_launched()) return;
  world = mpi::start();
  if (ranks() == nullptr) return;
  if (!is_root()) {
    output_.emplace(std::cout);
    log_.emplace(std::clog);
  }
#endif
}

Session::~Session() {
#ifdef DECID_MPI
  world.reset();
#endif
}

void Session::require_alike(const std::vector<std::string>& outputs) const {
  if (ranks() == nullptr) {
    if (launched_processes() > 1 && !has_mpi())
      throw Error(Code::not_supported, "decid",
                  format("was started %d times by mpirun or srun, and is built without MPI", launched_processes()),
                  "build it with -DDECID_MPI=ON (docs/guide/cluster.md), or start it once");
    return;
  }
  const std::vector<std::string> arguments(argv_ + 1, argv_ + argc_);
  require_same("decid", version, "install one version on all hosts");
  require_same("the command", joined(arguments, " "), "start all ranks with one command");
  bool written = false;  // the argument names an output
  for (const std::string& argument : arguments) {
    if (!written && !argument.starts_with("-"))
      require_same(argument, digest(argument), "give all hosts the same file");
    written = std::ranges::count(outputs, argument) > 0;
  }
  const std::vector<std::string> isas = gather_texts(ranks(), name(chosen_isa()));
  const auto other = std::ranges::find_if(isas, [&](const std::string& each) { return each != isas.front(); });
  const bool quiet = std::ranges::count(arguments, "--quiet") > 0;
  if (other != isas.end() && is_root() && !quiet)
    std::cerr << format(
        "note: rank 0 computes with %s, rank %d with %s: the bits are the same, the slowest sets the pace\n",
        isas.front().c_str(), static_cast<int>(other - isas.begin()), other->c_str());
}

bool Session::takes_part() const {
  const std::string command = argc_ > 1 ? argv_[1] : "";
  return is_root() || std::ranges::count(shared_commands, command) > 0;
}

int Session::end(int code, const std::string& text, void (*say)(const std::string&)) {
#ifdef DECID_MPI
  if (ranks() != nullptr) return world->end(code, text, say);
#endif
  if (code != 0 && !text.empty()) say(text);
  return code;
}

namespace {

/// Returns the bytes of a message. A worker sends nothing when it is free, or an item's number and its result. A worker
/// receives first and last; equal numbers end its work.
std::string message_of(std::uint64_t number, const std::string& rest) {
  std::string bytes(sizeof(number), '\0');
  std::memcpy(bytes.data(), &number, sizeof(number));
  return bytes + rest;
}
std::uint64_t number_in(const std::string& bytes, std::size_t place = 0) {
  std::uint64_t number = 0;
  std::memcpy(&number, bytes.data() + place, sizeof(number));
  return number;
}
constexpr std::uint64_t no_item = ~std::uint64_t{0};  // its sender has to stop

using Work = std::function<void(std::size_t first, std::size_t last, const detail::GiveBytes& give)>;

void serve(Communicator& group, const Work& work, const std::function<bool()>& stop) {
  for (;;) {
    group.send(0, {});
    std::optional<Communicator::Message> order;
    while (!(order = group.poll())) std::this_thread::sleep_for(std::chrono::microseconds(200));
    const std::uint64_t first = number_in(order->bytes), last = number_in(order->bytes, sizeof(first));
    if (first == last) return;
    std::mutex mutex;
    std::vector<std::string> given;  // only this thread calls MPI
    work(static_cast<std::size_t>(first), static_cast<std::size_t>(last),
         [&](std::size_t item, const std::string& bytes) {
           const std::lock_guard lock(mutex);
           given.push_back(message_of(item, bytes));
         });
    if (given.size() < last - first || stop()) given.push_back(message_of(no_item, {}));
    for (const std::string& message : given) group.send(0, message);
  }
}

/// Distributes the work at rank 0. Rank 0 works in a separate thread, while its main thread serves the other ranks;
/// only the main thread calls MPI.
class Giver {
 public:
  Giver(std::size_t count, std::size_t at_once) : count_(count), at_once_(std::max<std::size_t>(at_once, 1)) {}

  RankRange next() {
    const std::lock_guard lock(mutex_);
    if (stopped_) return {count_, count_};
    const std::size_t first = next_;
    next_ = std::min(first + at_once_, count_);
    return {first, next_};
  }
  void stop() {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  bool stopped() {
    const std::lock_guard lock(mutex_);
    return stopped_;
  }
  std::vector<std::pair<std::size_t, std::string>> done() {
    const std::lock_guard lock(mutex_);
    return std::exchange(done_, {});
  }

  /// Works until no item is left; the thread's body.
  void work_alone(const Work& work) {
    for (RankRange range = next(); range.count() > 0; range = next()) {
      std::atomic<std::size_t> given{0};
      work(range.first, range.last, [&](std::size_t item, std::string bytes) {
        const std::lock_guard lock(mutex_);
        done_.emplace_back(item, std::move(bytes));
        ++given;
      });
      if (given < range.count()) return stop();
    }
  }

 private:
  std::mutex mutex_;
  std::size_t count_, at_once_, next_ = 0;
  bool stopped_ = false;
  std::vector<std::pair<std::size_t, std::string>> done_;
};

}  // namespace

bool detail::work_alone(std::size_t count, std::size_t at_once,
                        const std::function<void(std::size_t first, std::size_t last)>& work,
                        const std::function<bool()>& stop) {
  at_once = std::max<std::size_t>(at_once, 1);
  for (std::size_t first = 0; first < count && !stop(); first += at_once) work(first, std::min(first + at_once, count));
  return !stop();
}

bool detail::share_bytes(std::size_t count, std::size_t at_once, const Work& work, const GiveBytes& take,
                         const std::function<bool()>& stop) {
  Communicator& group = *ranks();
  if (!group.is_root()) {
    serve(group, work, stop);
    return broadcast_text(&group, {}).empty();
  }
  Giver giver(count, at_once);
  std::future<void> own = std::async(std::launch::async, [&, threads = thread_count()] {
    omp_set_num_threads(threads);  // a new thread has a team of its own
    giver.work_alone(work);
  });
  const auto take_done = [&] {
    for (auto& done : giver.done()) take(done.first, std::move(done.second));
  };
  bool busy = true;
  for (int at_work = group.size() - 1; busy || at_work > 0;) {
    if (stop()) giver.stop();
    take_done();
    const std::optional<Communicator::Message> message = group.poll();
    if (!message) {
      if (busy && own.wait_for(std::chrono::microseconds(500)) == std::future_status::ready) {
        own.get();  // throws what its work threw
        busy = false;
      }
      if (!busy && at_work > 0) std::this_thread::sleep_for(std::chrono::microseconds(200));
    } else if (message->bytes.empty()) {
      const RankRange range = giver.next();
      group.send(message->from, message_of(range.first, message_of(range.last, {})));
      if (range.count() == 0) --at_work;
    } else if (number_in(message->bytes) == no_item) {
      giver.stop();
    } else {
      take(static_cast<std::size_t>(number_in(message->bytes)), message->bytes.substr(sizeof(std::uint64_t)));
    }
  }
  take_done();
  static_cast<void>(broadcast_text(&group, giver.stopped() ? "stopped" : ""));
  return !giver.stopped();
}

}  // namespace decid::tools
