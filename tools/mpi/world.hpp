// MPI's processes as a Communicator, and how they begin and end together.
#pragma once

#include <memory>
#include <string>

#include "base/communicator.hpp"

namespace decid::mpi {

class World : public Communicator {
 public:
  /// Returns the number of processes of this machine that may run on the same processors as this one, itself among
  /// them.
  virtual int sharing_processors() const = 0;
  /// Ends this rank's work with an exit code and a message, which may be empty. Returns the highest code of all ranks,
  /// once every rank has ended; rank 0, or the first that failed if that did not, calls `say`
  /// with its text. If other ranks do not end within some seconds of a failure, this rank reports its own and ends
  /// them all; then it does not return.
  virtual int end(int code, const std::string& text, void (*say)(const std::string&)) = 0;
};

/// Returns true if mpirun or srun started this process, with or without others.
bool is_launched();
/// MPI, initialised; once in a process, by the only thread that will use it. It ends with the object, for good.
std::unique_ptr<World> start();

}  // namespace decid::mpi
