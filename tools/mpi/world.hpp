// MPI's processes as a Communicator, and how they begin and end together.
#pragma once

#include <memory>
#include <string>

#include "base/communicator.hpp"

namespace decid::mpi {

class World : public Communicator {
 public:
  /// Processes of this machine that may run on the same processors as this one, itself among them.
  virtual int sharing_processors() const = 0;
  /// How this rank's work ended: an exit code, and what it has to say, which may be nothing. Returns the code of all
  /// together, the highest, once every rank has ended; rank 0, or the first that failed if that did not, calls `say`
  /// with its text. Where others do not come to an end within some seconds of a failure, this rank says its own and
  /// ends them all; it does not return then.
  virtual int end(int code, const std::string& text, void (*say)(const std::string&)) = 0;
};

/// Returns true if mpirun or srun started this process, with or without others.
bool is_launched();
/// MPI, initialised; once in a process, by the only thread that will use it. It ends with the object, for good.
std::unique_ptr<World> start();

}  // namespace decid::mpi
