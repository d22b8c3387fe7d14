// How the program takes memory.
#pragma once

namespace decid::tools {

/// Before anything is allocated: the heap begins with large pages where the system has them, and keeps what is freed
/// for what comes next. The libraries leave the heap to whoever uses them.
void prepare_heap();

}  // namespace decid::tools
