// The processes that mpirun or srun has started for one call: which command they share, what they must have in common,
// and how work is given out among them. Rank 0 alone reads answers together, prints and writes; without MPI there is
// only it.
#pragma once

#include <cstddef>
#include <functional>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "base/archive.hpp"
#include "base/communicator.hpp"

namespace decid::tools {

/// Null: this process works alone.
Communicator* ranks();
/// Prints and writes.
bool is_root();
/// Threads that a process has if nobody says: all processors, or its part of them if other ranks run on the same.
void share_processors();

/// Throws Error, naming the ranks, unless all have the same text.
void require_same(const std::string& what, const std::string& text, const std::string& remedy);
/// Name and size of each file, for require_same().
std::string listed(const std::vector<std::string>& files);

/// From the first to the last statement of main().
class Session {
 public:
  /// Joins the others, if there are any.
  Session(int argc, char** argv);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Looks whether all have been started alike, as require_same() does: this decid, these arguments, the files that
  /// they name for reading. Says so if instruction sets differ, unless --quiet is among the arguments.
  void require_alike() const;
  /// False: rank 0 does all there is to do, as this command is not shared.
  bool takes_part() const;
  /// The exit code of all ranks together; the text of one that failed is said once.
  int end(int code, const std::string& text, void (*say)(const std::string&));

 private:
  int argc_;
  char** argv_;
};

/// Returns rank 0's value at all.
template <class Value>
Value broadcast_value(Value value) {
  return ranks() == nullptr ? value : from_bytes<Value>(broadcast_text(*ranks(), to_bytes(value)));
}

/// Hands over the value of an item; from any thread.
template <class Value>
using Give = std::function<void(std::size_t item, Value value)>;

/// Gives out items 0 .. count - 1 to the ranks as they become free, up to `at_once` at a time. work(first, last, give):
/// gives the value of each of these once, in any order, or of fewer if it is to stop; called by each rank in a thread
/// that may be another than the caller's. take(item, value): called at rank 0, by one thread at a time, as they come.
/// Every rank makes this call. stop: asked at every rank. Returns false at all if the work was stopped. Values travel
/// as bytes (base/archive.hpp); a process alone moves them.
template <class Value>
bool share_out(std::size_t count, std::size_t at_once,
               const std::function<void(std::size_t first, std::size_t last, const Give<Value>& give)>& work,
               const Give<Value>& take, const std::function<bool()>& stop);

namespace detail {
/// The same for one process, and for bytes among several.
bool work_alone(std::size_t count, std::size_t at_once,
                const std::function<void(std::size_t first, std::size_t last)>& work,
                const std::function<bool()>& stop);
using GiveBytes = Give<std::string>;
bool share_bytes(std::size_t count, std::size_t at_once,
                 const std::function<void(std::size_t first, std::size_t last, const GiveBytes& give)>& work,
                 const GiveBytes& take, const std::function<bool()>& stop);
}  // namespace detail

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
