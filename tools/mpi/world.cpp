// MPI as a Communicator: see world.hpp. Each kind of call has a communicator of MPI's of its own, so that their orders
// do not mix. Nothing waits inside of MPI, which would keep a processor from threads that work.
#include "tools/mpi/world.hpp"

#include <mpi.h>
#include <sched.h>

#include <algorithm>
#include <chrono>
#include <climits>
#include <cstdlib>
#include <thread>
#include <vector>

#include "base/error.hpp"

namespace decid::mpi {
namespace {

void check(int result, const char* what) {
  if (result == MPI_SUCCESS) return;
  char text[MPI_MAX_ERROR_STRING] = {};
  int length = 0;
  MPI_Error_string(result, text, &length);
  throw Error(Code::system_failed, "MPI", std::string(what) + " failed: " + text,
              "check that all hosts run and reach each other");
}

class Request {
 public:
  MPI_Request* operator&() { return &request_; }
  bool test() {
    int done = 0;
    check(MPI_Test(&request_, &done, MPI_STATUS_IGNORE), "a transfer");
    return done != 0;
  }
  /// Looks, then gives way to threads that work, then sleeps: others may be far behind.
  void wait() {
    constexpr int looks = 200, turns = 1000;
    for (int i = 0; !test(); ++i) {
      if (i >= turns)
        std::this_thread::sleep_for(std::chrono::microseconds(20));
      else if (i >= looks)
        std::this_thread::yield();
    }
  }

 private:
  MPI_Request request_ = MPI_REQUEST_NULL;
};

/// Sizes and offsets as MPI takes them.
struct Counts {
  explicit Counts(std::span<const std::size_t> sizes) {
    std::size_t place = 0;
    for (const std::size_t size : sizes) {
      counts.push_back(static_cast<int>(size));
      places.push_back(static_cast<int>(place));
      place += size;
    }
    if (place > INT_MAX)
      throw Error(Code::system_failed, "MPI", "more than 2 GB at once", "use smaller layers, or fewer results a call");
  }
  std::vector<int> counts, places;
};

/// The counts stay as long as the request: MPI reads them meanwhile.
class Collective final : public Communicator::Transfer {
 public:
  Collective(std::span<const std::size_t> out, std::span<const std::size_t> in) : out_(out), in_(in) {}
  bool test() override { return done_ = done_ || request_.test(); }
  void wait() override {
    if (!done_) request_.wait();
    done_ = true;
  }

  void exchange(std::span<const std::byte> out, std::span<std::byte> in, MPI_Comm comm) {
    check(MPI_Ialltoallv(out.data(), out_.counts.data(), out_.places.data(), MPI_BYTE, in.data(), in_.counts.data(),
                         in_.places.data(), MPI_BYTE, comm, &request_),
          "an exchange");
  }
  void gather(std::span<const std::byte> own, std::span<std::byte> all, MPI_Comm comm) {
    check(MPI_Iallgatherv(own.data(), static_cast<int>(own.size()), MPI_BYTE, all.data(), in_.counts.data(),
                          in_.places.data(), MPI_BYTE, comm, &request_),
          "a gathering");
  }

 private:
  Counts out_, in_;
  Request request_;
  bool done_ = false;
};

class MpiWorld final : public World {
 public:
  MpiWorld() {
    int provided = 0;
    check(MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided), "its start");
    MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
    for (MPI_Comm* comm : {&blocking_, &exchanges_, &gathers_, &messages_, &ends_})
      check(MPI_Comm_dup(MPI_COMM_WORLD, comm), "its start");
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
    char name[MPI_MAX_PROCESSOR_NAME] = {};
    int length = 0;
    MPI_Get_processor_name(name, &length);
    host_.assign(name, static_cast<std::size_t>(length));
    if (provided < MPI_THREAD_FUNNELED)
      throw Error(Code::system_failed, "MPI", "was built without threads",
                  "use Debian's openmpi or mpich, or another with MPI_THREAD_FUNNELED");
    count_sharing();
  }
  ~MpiWorld() override {
    for (Sending& sending : sendings_) MPI_Wait(&sending.request, MPI_STATUS_IGNORE);
    MPI_Finalize();
  }
  MpiWorld(const MpiWorld&) = delete;
  MpiWorld& operator=(const MpiWorld&) = delete;

  int rank() const override { return rank_; }
  int size() const override { return size_; }
  int sharing_processors() const override { return sharing_; }

  void broadcast(std::span<std::byte> bytes) override {
    constexpr std::size_t max_bytes = std::size_t{1} << 30;
    for (std::size_t first = 0; first < bytes.size(); first += max_bytes) {
      Request request;
      const auto part = bytes.subspan(first, std::min(max_bytes, bytes.size() - first));
      check(MPI_Ibcast(part.data(), static_cast<int>(part.size()), MPI_BYTE, 0, blocking_, &request), "a broadcast");
      request.wait();
    }
  }
  void all_gather(std::span<const std::byte> own, std::span<const std::size_t> sizes,
                  std::span<std::byte> all) override {
    Collective collective({}, sizes);
    collective.gather(own, all, blocking_);
    collective.wait();
  }
  std::unique_ptr<Transfer> start_exchange(std::span<const std::byte> out, std::span<const std::size_t> out_sizes,
                                           std::span<std::byte> in, std::span<const std::size_t> in_sizes) override {
    auto transfer = std::make_unique<Collective>(out_sizes, in_sizes);
    transfer->exchange(out, in, exchanges_);
    return transfer;
  }
  std::unique_ptr<Transfer> start_all_gather(std::span<const std::byte> own, std::span<const std::size_t> sizes,
                                             std::span<std::byte> all) override {
    auto transfer = std::make_unique<Collective>(std::span<const std::size_t>(), sizes);
    transfer->gather(own, all, gathers_);
    return transfer;
  }

  void send(int to, const std::string& bytes) override {
    if (bytes.size() > INT_MAX)
      throw Error(Code::system_failed, "MPI", "a message of more than 2 GB", "give fewer recordings a call");
    std::erase_if(sendings_, [](Sending& sending) { return sending.request.test(); });
    Sending& sending = sendings_.emplace_back();
    sending.bytes = std::make_unique<std::string>(bytes);
    check(
        MPI_Isend(sending.bytes->data(), static_cast<int>(bytes.size()), MPI_BYTE, to, 0, messages_, &sending.request),
        "a message");
  }
  std::optional<Message> poll() override {
    std::erase_if(sendings_, [](Sending& sending) { return sending.request.test(); });
    int there = 0, length = 0;
    MPI_Status status;
    check(MPI_Iprobe(MPI_ANY_SOURCE, 0, messages_, &there, &status), "waiting for messages");
    if (there == 0) return std::nullopt;
    MPI_Get_count(&status, MPI_BYTE, &length);
    Message message{status.MPI_SOURCE, std::string(static_cast<std::size_t>(length), '\0')};
    check(MPI_Recv(message.bytes.data(), length, MPI_BYTE, message.from, 0, messages_, MPI_STATUS_IGNORE), "a message");
    return message;
  }

  int end(int code, const std::string& text, void (*say)(const std::string&)) override {
    using Clock = std::chrono::steady_clock;
    // Others may be where they cannot notice. Rank 0 first, so that one alone speaks.
    const auto latest = Clock::now() + std::chrono::milliseconds(2000 + std::min(200 * rank_, 2000));
    std::vector<int> codes(static_cast<std::size_t>(size_));
    Request request;
    check(MPI_Iallgather(&code, 1, MPI_INT, codes.data(), 1, MPI_INT, ends_, &request), "its end");
    while (!request.test()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      if (code == 0 || Clock::now() < latest) continue;
      say(size_ > 1 ? "rank " + std::to_string(rank_) + " on " + host_ + ": " + text : text);
      MPI_Abort(MPI_COMM_WORLD, code);
    }
    const int highest = *std::ranges::max_element(codes);
    const auto failed = std::ranges::find_if(codes, [](int each) { return each != 0; });
    const auto speaker = static_cast<int>(failed - codes.begin());
    if (failed != codes.end() && rank_ == speaker)
      say(speaker > 0 ? "rank " + std::to_string(rank_) + " on " + host_ + ": " + text : text);
    return highest;
  }

 private:
  /// Ranks of this machine with the same set of processors: mpirun may have bound each to some of its own.
  void count_sharing() {
    cpu_set_t own;
    CPU_ZERO(&own);
    sched_getaffinity(0, sizeof(own), &own);
    MPI_Comm machine = MPI_COMM_NULL;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, rank_, MPI_INFO_NULL, &machine);
    int there = 0;
    MPI_Comm_size(machine, &there);
    std::vector<cpu_set_t> all(static_cast<std::size_t>(there));
    MPI_Allgather(&own, sizeof(own), MPI_BYTE, all.data(), sizeof(own), MPI_BYTE, machine);
    MPI_Comm_free(&machine);
    sharing_ =
        static_cast<int>(std::ranges::count_if(all, [&](const cpu_set_t& set) { return CPU_EQUAL(&set, &own); }));
  }

  struct Sending {
    std::unique_ptr<std::string> bytes;
    Request request;
  };
  MPI_Comm blocking_ = MPI_COMM_NULL, exchanges_ = MPI_COMM_NULL, gathers_ = MPI_COMM_NULL, messages_ = MPI_COMM_NULL,
           ends_ = MPI_COMM_NULL;
  int rank_ = 0, size_ = 1, sharing_ = 1;
  std::string host_;
  std::vector<Sending> sendings_;
};

}  // namespace

bool is_launched() {
  // Open MPI's mpirun; MPICH's, Intel's and srun with PMI-1 or 2; srun with PMIx.
  return std::ranges::any_of(
      std::initializer_list<const char*>{"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMI_RANK", "PMIX_RANK"},
      [](const char* name) { return std::getenv(name) != nullptr; });
}

std::unique_ptr<World> start() {
  return std::make_unique<MpiWorld>();
}

}  // namespace decid::mpi
