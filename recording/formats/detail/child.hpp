// Runs work on untrusted input in a child process, so that a crash, hang or lack of memory stays there.
// POSIX: fork, setrlimit, waitpid.
// Not installed.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

namespace decid::recording {

struct ChildLimits {
  std::size_t memory_bytes;  ///< beyond this process's memory; not enforced with sanitizers, which need more
  unsigned seconds;          ///< of processor time
};

/// Returns the result of `work`, called in a child process. Returns nothing if the child crashed, threw or exceeded a
/// limit. `work` must not need other threads, locks that they may hold, or OpenMP. The child's standard output and
/// error are discarded. Throws Error if no child can be started.
std::optional<std::string> in_child(const std::function<std::string()>& work, const ChildLimits& limits);

}  // namespace decid::recording
