// Generates a data set directly into its file: see npz.hpp, and journal.hpp for resuming. The unfinished file is the
// beginning of the finished one, so resuming means skipping the existing sound part.
#include <fcntl.h>
#include <omp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <future>
#include <optional>
#include <system_error>

#include "base/error.hpp"
#include "base/files/json_object.hpp"
#include "base/parallel.hpp"
#include "base/per_thread.hpp"
#include "dataset/npz/detail/journal.hpp"
#include "dataset/npz/detail/npz_parts.hpp"
#include "dataset/npz/npz.hpp"
#include "dataset/sets/generator.hpp"
#include "sim/protocol/protocol_object.hpp"

namespace decid::dataset {
namespace {

namespace fs = std::filesystem;

/// Returns the file that the name refers to, following symbolic links.
fs::path target_of(const fs::path& path) {
  std::error_code error;
  const fs::path target = fs::weakly_canonical(path, error);
  const fs::file_status status = fs::status(error ? path : target, error);
  if (fs::is_directory(status))
    throw Error(Code::file_unwritable, path.string(), "is a folder", "give the name of a file");
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw Error(Code::file_unwritable, path.string(), "is not a regular file, and a data set cannot be streamed",
                "give a file on a disk");
  }
  return target.empty() ? path : target;
}

/// Returns a text of everything that determines the file's bits.
std::string request_text(const DatasetRequest& request, const std::string& program) {
  return print_json({{"format", npz_format_version},
                     {"program", program},
                     {"seed", request.seed},
                     {"count", request.count},
                     {"base", request.base == 0 ? request.count : request.base},
                     {"protocol", sim::to_json_object(request.protocol)}});
}

/// Returns "seed 1, not 2": the difference between a partial file's request and this one.
std::string difference(const std::string& found, const std::string& wanted) {
  const Json theirs = parse_json(found, "journal"), ours = parse_json(wanted, "request");
  std::string text;
  for (const auto& [key, value] : ours.items()) {
    if (theirs.contains(key) && theirs[key] == value) continue;
    if (!text.empty()) text += "; ";
    if (value.is_object() || !theirs.contains(key)) {
      text += "another " + key;
    } else {
      text += key + " " + theirs[key].dump() + ", not " + value.dump();
    }
  }
  return text;
}

/// The unfinished file and its journal, which one process at a time may open.
class Partial {
 public:
  explicit Partial(const NpzPartial& paths)
      : paths_(paths), file_(paths.file, DiskFile::Access::write), journal_(open(file_, paths)) {}
  /// Opens files that another process has opened; `identity` is that process's identity().
  Partial(const NpzPartial& paths, const std::string& identity)
      : paths_(paths), file_(paths.file, DiskFile::Access::write), journal_(paths.journal) {
    if (this->identity() != identity)
      throw Error(Code::system_failed, paths.file.string(), "is not the file that rank 0 writes",
                  "name a folder that all hosts share");
  }
  /// Returns an identity of the file that is independent of its mount.
  std::string identity() const {
    struct stat status {};
    if (::stat(paths_.file.c_str(), &status) != 0) return {};
    return std::to_string(status.st_ino) + " " + std::to_string(status.st_size);
  }

  DiskFile& file() { return file_; }
  ChunkJournal& journal() { return journal_; }

  /// Prepares the journal for reading, or begins it; refuses the file of another request, and another program's
  /// journal.
  void take(const std::string& request) {
    if (file_.size() == 0 && journal_.is_foreign()) {
      std::error_code ignored;
      fs::remove(paths_.file, ignored);
      throw Error(Code::file_unsupported, paths_.journal.string(), "is not a journal of this decid's data sets",
                  "delete it, or choose another output");
    }
    const std::optional<std::string> found = journal_.request();
    // The journal's beginning reaches the disk before anything reaches the file, which is worthless without it.
    begun_ = file_.size() == 0;
    if (begun_) return journal_.start(request);
    const std::string remedy = "delete " + paths_.file.string() + " and " + paths_.journal.string() + " to start again";
    if (!found)
      throw Error(Code::file_damaged, paths_.file.string(), "is an unfinished data set whose journal is lost", remedy);
    if (*found != request) {
      throw Error(Code::file_differs, paths_.file.string(),
                  "is an unfinished data set of another request (" + difference(*found, request) + ")",
                  "give the options it was begun with, or " + remedy);
    }
  }

  /// Removes the files if this call began them: others may hold the work of hours.
  void remove_if_begun() {
    if (!begun_) return;
    std::error_code ignored;
    fs::remove(paths_.file, ignored);
    fs::remove(paths_.journal, ignored);
  }

  /// Gives the finished file its name, after its content is on the disk.
  void commit(const fs::path& target) {
    std::error_code ignored;
    const fs::file_status old = fs::status(target, ignored);
    if (fs::exists(old)) fs::permissions(paths_.file, old.permissions(), ignored);
    file_.sync();
    std::error_code error;
    fs::rename(paths_.file, target, error);
    if (error) {
      throw Error(Code::file_unwritable, target.string(), "cannot be replaced: " + error.message(),
                  "check the permissions of its folder");
    }
    fs::remove(paths_.journal, ignored);
    const fs::path folder = target.parent_path().empty() ? "." : target.parent_path();
    if (const int number = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); number >= 0) {
      static_cast<void>(::fsync(number));
      ::close(number);
    }
  }

 private:
  static ChunkJournal open(DiskFile& file, const NpzPartial& paths) {
    if (!file.try_lock() || !file.is_still_at_its_path()) {
      throw Error(Code::file_in_use, paths.file.string(), "is being written by another decid",
                  "wait for it, or choose another output");
    }
    return ChunkJournal(paths.journal);
  }

  NpzPartial paths_;
  DiskFile file_;
  ChunkJournal journal_;
  bool begun_ = false;  // by this call
};

std::vector<std::span<const std::byte>> bytes_of(const std::vector<std::span<const float>>& sway) {
  std::vector<std::span<const std::byte>> pieces;
  pieces.reserve(sway.size());
  for (const std::span<const float> trial : sway) pieces.push_back(std::as_bytes(trial));
  return pieces;
}

/// Returns the CRC-32 of `trials` trials of the file, or nothing if the file ends earlier.
std::optional<std::uint32_t> crc32_of(const DiskFile& file, std::uint64_t position, std::size_t trials,
                                      std::size_t trial_bytes) {
  if (position + trials * trial_bytes > file.size()) return std::nullopt;
  std::vector<std::uint32_t> parts(trials);
  parallel_for(static_cast<int>(trials), [&](int i) {
    struct Scratch {
      std::vector<std::byte> bytes;
    };
    std::vector<std::byte>& bytes = per_thread<Scratch>().bytes;
    bytes.resize(trial_bytes);
    const auto index = static_cast<std::size_t>(i);
    file.read(position + index * trial_bytes, bytes);
    parts[index] = crc32(bytes);
  });
  std::uint32_t sum = 0;
  for (const std::uint32_t part : parts) sum = crc32_joined(sum, part, trial_bytes);
  return sum;
}

class Run {
 public:
  Run(Partial& partial, Generator& generator, const Progress& progress, Communicator* ranks)
      : partial_(partial),
        generator_(generator),
        progress_(progress),
        ranks_(ranks),
        zip_(partial.file()),
        trial_bytes_(static_cast<std::size_t>(generator.samples()) * sizeof(float)) {
    begin_array<float>(
        zip_, "sway",
        {static_cast<std::size_t>(generator.request().count), static_cast<std::size_t>(generator.samples())});
  }

  /// Skips the existing chunks up to the first that differs from the journal; trials: the number that another process
  /// has verified.
  void take_up(std::optional<int> trials_there = {}) {
    ChunkJournal& journal = partial_.journal();
    while (generator_.trials() != trials_there) {
      const std::optional<JournalEntry> entry = journal.next(generator_.trials());
      if (!entry) break;
      const std::size_t trials = entry->chunk.trials.size();
      if (trials > static_cast<std::size_t>(generator_.request().count - generator_.trials()) ||
          (!trials_there && crc32_of(partial_.file(), zip_.position(), trials, trial_bytes_) != entry->sway_crc32)) {
        journal.back();
        break;
      }
      zip_.skip(trials * trial_bytes_, entry->sway_crc32);
      generator_.restore(entry->chunk);
      if (ranks_ == nullptr && !go_on()) throw stopped();
    }
  }

  /// Writes a chunk while the next one is simulated.
  void make_the_rest() {
    std::future<std::vector<std::uint32_t>> writing;
    const Chunk* written = nullptr;
    bool stop = false;
    int before = 0;  // trials before it
    const auto finish_writing = [&] {
      if (writing.valid()) stop = note(*written, before, writing.get(), stop);
    };
    while (!generator_.done() && !stop) {
      const int trials = generator_.trials();
      const Chunk& chunk = next_chunk();
      finish_writing();
      written = &chunk;
      before = trials;
      // A new thread has its own OpenMP team: it gets as many threads as the caller's.
      writing = std::async(std::launch::async, [this, &chunk, threads = thread_count()] {
        omp_set_num_threads(threads);
        return write(chunk);
      });
      const bool asked = !go_on();
      if (ranks_ == nullptr) stop = asked;
      asked_ = asked_ || asked;
    }
    finish_writing();
    if (stop) throw stopped();
    zip_.end();
  }

  void finish() {
    const DatasetRequest& request = generator_.request();
    begin_array<double>(zip_, "parameters",
                        {static_cast<std::size_t>(request.count), request.protocol.parameters().size()});
    ChunkJournal& journal = partial_.journal();
    static_cast<void>(journal.request());  // back to its first entry
    std::vector<sim::Parameters> parameters;
    int trials = 0;
    while (const std::optional<JournalEntry> entry = journal.next(trials)) {
      parameters.clear();
      for (const TrialRecord& trial : entry->chunk.trials) parameters.push_back(trial.parameters);
      zip_.write(parameter_bytes(parameters));
      trials += static_cast<int>(parameters.size());
    }
    if (trials != request.count) {
      throw Error(Code::file_damaged, partial_.file().path().string(), "its journal was damaged during the run",
                  "run the same command again");
    }
    zip_.end();
    finish_archive(zip_, generator_.group(), split_by_group(generator_.group()),
                   describe(request.protocol, request.seed));
  }

 private:
  /// Leaves no files if the request is impossible. After other errors, as of a network, the same command continues.
  const Chunk& next_chunk() {
    try {
      return generator_.next();
    } catch (const Error& error) {
      const bool is_impossible = error.code() == Code::body_falls || error.code() == Code::trials_missing;
      if (is_impossible && is_writer()) partial_.remove_if_begun();
      throw;
    }
  }

  /// Writes this process's trials at their places; returns the CRC-32 of each.
  std::vector<std::uint32_t> write(const Chunk& chunk) {
    std::uint64_t place = zip_.position();
    for (int rank = 0; ranks_ != nullptr && rank < ranks_->rank(); ++rank)
      place += chunk.trials_by_rank[static_cast<std::size_t>(rank)] * trial_bytes_;
    const std::vector<std::span<const std::byte>> pieces = bytes_of(chunk.sway);
    std::vector<std::uint32_t> sums(pieces.size());
    parallel_for(static_cast<int>(pieces.size()),
                 [&](int i) { sums[static_cast<std::size_t>(i)] = crc32(pieces[static_cast<std::size_t>(i)]); });
    partial_.file().write(place, pieces);
    partial_.file().start_writeback(place, pieces.size() * trial_bytes_);
    return sums;
  }

  /// Records the chunk in the journal after all processes have written. Returns true if one of them must stop.
  bool note(const Chunk& chunk, int trials_before, std::vector<std::uint32_t> sums, bool stop) {
    if (ranks_ != nullptr) {
      sums.push_back(asked_ ? 1 : 0);
      std::vector<std::size_t> sizes;
      for (const std::size_t trials : chunk.trials_by_rank) sizes.push_back((trials + 1) * sizeof(std::uint32_t));
      const std::vector<std::uint32_t> own = std::move(sums);
      sums.assign(chunk.trials.size() + sizes.size(), 0);
      ranks_->all_gather(std::as_bytes(std::span(own)), sizes, std::as_writable_bytes(std::span(sums)));
      std::size_t place = 0;
      for (const std::size_t trials : chunk.trials_by_rank) {
        place += trials;
        stop = stop || sums[place] != 0;
        sums.erase(sums.begin() + static_cast<std::ptrdiff_t>(place));
      }
    }
    std::uint32_t sum = 0;
    for (const std::uint32_t each : sums) sum = crc32_joined(sum, each, trial_bytes_);
    zip_.skip(sums.size() * trial_bytes_, sum);
    if (is_writer())
      partial_.journal().append({{chunk.trials, {}, chunk.base_attempts, chunk.child_attempts, {}}, sum},
                                trials_before);
    return stop;
  }

  /// Returns true for the process that writes everything except other processes' sway.
  bool is_writer() const { return ranks_ == nullptr || ranks_->is_root(); }

  bool go_on() const { return !progress_ || progress_(generator_.trials(), generator_.request().count); }

  Error stopped() const {
    return Error(Code::stopped, partial_.file().path().string(),
                 "stopped after " + std::to_string(generator_.trials()) + " of " +
                     std::to_string(generator_.request().count) + " trials",
                 "run the same command to continue");
  }

  Partial& partial_;
  Generator& generator_;
  const Progress& progress_;
  Communicator* ranks_;
  ZipWriter zip_;
  bool asked_ = false;  // this process was asked to stop
  std::size_t trial_bytes_;
};

}  // namespace

NpzPartial npz_partial(const fs::path& path) {
  fs::path file = target_of(path);
  file += ".partial";
  fs::path journal = file;
  journal += ".journal";
  return {file, journal};
}

DatasetReport generate_npz(const fs::path& path, const DatasetRequest& request, const std::string& program,
                           const Progress& progress, const std::function<void(int trials)>& resumed,
                           Communicator* ranks) {
  Generator generator(request, ranks);
  const bool is_writer = ranks == nullptr || ranks->is_root();
  std::optional<Partial> partial;
  if (is_writer) {
    partial.emplace(npz_partial(path));
    partial->take(request_text(request, program));
  }
  const std::string identity = broadcast_text(ranks, is_writer ? partial->identity() : std::string());
  if (!is_writer) {
    partial.emplace(npz_partial(path), identity);
    static_cast<void>(partial->journal().request());
  }
  static_cast<void>(gather_texts(ranks, {}));  // all processes check before any writes
  Run run(*partial, generator, progress, ranks);
  if (is_writer) run.take_up();
  const int there = std::stoi(broadcast_text(ranks, std::to_string(generator.trials())));
  if (!is_writer) run.take_up(there);
  if (generator.trials() != there)
    throw Error(Code::system_failed, npz_partial(path).journal.string(),
                "shows " + std::to_string(generator.trials()) + " trials, and rank 0 reads " + std::to_string(there),
                "name a folder of which all hosts see the same content, and run the same command again");
  static_cast<void>(gather_texts(ranks, {}));  // the journal has been read
  if (resumed && generator.trials() > 0) resumed(generator.trials());
  run.make_the_rest();
  if (is_writer) {
    run.finish();
    partial->commit(target_of(path));
  }
  static_cast<void>(broadcast_text(ranks, {}));  // the file exists
  return generator.report();
}

}  // namespace decid::dataset
