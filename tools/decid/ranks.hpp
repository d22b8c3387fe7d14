// The processes that mpirun or srun started for one call: which commands they share, which settings they must have in
// common, and how they divide the work. Only rank 0 merges answers, prints and writes. Without MPI there is only rank
// 0.
#pragma once

#include <cstddef>
#include <functional>
#include <iosfwd>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/archive.hpp"
#include "base/communicator.hpp"

namespace decid::tools {

/// Returns null if this is the only process.
Communicator* ranks();
/// Returns true at the rank that prints and writes.
bool is_root();

/// Discards what is written to a stream for its lifetime. Several may silence one stream if the last one ends first.
class Silenced {
 public:
  explicit Silenced(std::ostream& stream);
  ~Silenced();
  Silenced(const Silenced&) = delete;
  Silenced& operator=(const Silenced&) = delete;

 private:
  std::ostream& stream_;
  std::streambuf* before_;
};

/// Sets the default number of threads of a process: all processors, or a part of them if other ranks run on the same
/// machine.
void share_processors();

/// Throws Error, naming the ranks, unless all ranks have the same text.
void require_same(const std::string& what, const std::string& text, const std::string& remedy);
/// Returns the name and size of each file, for require_same().
std::string listed(const std::vector<std::string>& files);

/// Connects the ranks; lives from the first to the last statement of main().
class Session {
 public:
  /// Joins the other ranks, if there are any.
  Session(int argc, char** argv);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Checks that all ranks were started alike, as require_same() does: this decid, these arguments, and the files that
  /// the arguments name for reading. outputs: the options that name files to write, which only rank 0 has. Prints a
  /// message if instruction sets differ, unless --quiet is among the arguments.
  void require_alike(const std::vector<std::string>& outputs) const;
  /// Returns false if rank 0 does all the work, because the ranks do not share this command.
  bool takes_part() const;
  /// Returns the common exit code of all ranks. Prints the error text of a failed rank once.
  int end(int code, const std::string& text, void (*say)(const std::string&));

 private:
  int argc_;
  char** argv_;
  std::optional<Silenced> output_, log_;  ///< of a rank that prints nothing
};

/// Returns rank 0's value at all ranks.
template <class Value>
Value broadcast_value(Value value) {
  if (ranks() == nullptr) return value;  // without copies
  return from_bytes<Value>(broadcast_text(ranks(), to_bytes(value)));
}
/// Returns every rank's value, in order of ranks.
template <class Value>
std::vector<Value> gather_values(const Value& own) {
  std::vector<Value> all;
  for (const std::string& bytes : gather_texts(ranks(), to_bytes(own))) all.push_back(from_bytes<Value>(bytes));
  return all;
}

/// Receives the value of an item; any thread may call it.
template <class Value>
using Give = std::function<void(std::size_t item, Value value)>;

namespace detail {
/// Do as share_out() for one process, and for bytes among several processes.
bool work_alone(std::size_t count, std::size_t at_once,
                const std::function<void(std::size_t first, std::size_t last)>& work,
                const std::function<bool()>& stop);
using GiveBytes = Give<std::string>;
bool share_bytes(std::size_t count, std::size_t at_once,
                 const std::function<void(std::size_t first, std::size_t last, const GiveBytes& give)>& work,
                 const GiveBytes& take, const std::function<bool()>& stop);
}  // namespace detail

/// Distributes items 0 .. count - 1 to the ranks as they become free, up to `at_once` at a time. Every rank calls this
/// function. work(first, last, give): calls give once for each of these items, in any order, or for fewer if it has to
/// stop. Each rank calls work in a thread that may differ from the caller's. take(item, value): rank 0 calls it as
/// values arrive, from one thread at a time. stop: every rank calls it. Returns false at all ranks if the work was
/// stopped. Values travel as bytes (base/archive.hpp); a single process moves them.
template <class Value>
bool share_out(std::size_t count, std::size_t at_once,
               const std::function<void(std::size_t first, std::size_t last, const Give<Value>& give)>& work,
               const Give<Value>& take, const std::function<bool()>& stop) {
  if (ranks() == nullptr) {
    std::mutex one_at_a_time;
    const Give<Value> give = [&](std::size_t item, Value value) {
      const std::lock_guard lock(one_at_a_time);
      take(item, std::move(value));
    };
    return detail::work_alone(
        count, at_once, [&](std::size_t first, std::size_t last) { work(first, last, give); }, stop);
  }
  return detail::share_bytes(
      count, at_once,
      [&](std::size_t first, std::size_t last, const detail::GiveBytes& give) {
        work(first, last, [&](std::size_t item, Value value) { give(item, to_bytes(value)); });
      },
      [&](std::size_t item, const std::string& bytes) { take(item, from_bytes<Value>(bytes)); }, stop);
}

}  // namespace decid::tools
