// Work on untrusted input in a process of its own, which may crash, hang or run out of memory alone.
// POSIX: fork, setrlimit, waitpid.
// Not installed.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

namespace decid::recording {

struct ChildLimits {
  std::size_t memory_bytes;  ///< beyond what this process has; not held with sanitizers, whose own are larger
  unsigned seconds;          ///< of a processor
};

/// What `work` returns, called in a child of this process; nothing if the child ended in any other way: by a crash, an
/// exception, or a limit. work must not need other threads, locks that these may hold, or OpenMP. The child's standard
/// output and error lead nowhere. Throws Error if there can be no child.
std::optional<std::string> in_child(const std::function<std::string()>& work, const ChildLimits& limits);

}  // namespace decid::recording
