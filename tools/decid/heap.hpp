// Configures how the program allocates memory.
#pragma once

namespace decid::tools {

/// Configures the heap; call it before the first allocation. The heap begins with large pages where the system has
/// them, and keeps freed memory for later allocations. The libraries leave the heap to the calling program.
void prepare_heap();

}  // namespace decid::tools
