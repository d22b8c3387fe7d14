// The processes that mpirun or srun has started for one call: which command they share, what they must have in common,
// and how work is given out among them. Rank 0 alone reads answers together, prints and writes; without MPI there is
// only it.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

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

/// Gives out items 0 .. count - 1 to the ranks as they become free, up to `at_once` at a time. work(first, last): the
/// results of these, in order; nothing if it is to stop; called by each rank in a thread that may be another than the
/// caller's. take(item, result): called at rank 0, by the caller's thread, as they come. Every rank makes this call.
/// stop: asked at rank 0. Returns false at all if the work was stopped.
bool share_out(std::size_t count, std::size_t at_once,
               const std::function<std::vector<std::string>(std::size_t first, std::size_t last)>& work,
               const std::function<void(std::size_t item, const std::string& result)>& take,
               const std::function<bool()>& stop);

}  // namespace decid::tools
