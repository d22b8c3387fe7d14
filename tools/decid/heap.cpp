// The heap: see heap.hpp. A recording's way to its result takes some 20 MB in blocks of up to 3 MB. Left to itself the
// C library maps such blocks from the system and gives them back, and each page of 4 KB that is touched is a trap.
#include "tools/decid/heap.hpp"

#include <cstdint>
#include <cstdlib>

#if defined(__GLIBC__)
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace decid::tools {

void prepare_heap() {
#if defined(__GLIBC__)
  constexpr int block = 32 << 20;  // what the C library's own threshold grows to, in time
  constexpr std::uintptr_t page = 2 << 20;
  mallopt(M_MMAP_THRESHOLD, block);
  mallopt(M_TRIM_THRESHOLD, 2 * block);
  const auto beyond_page = [](const char* place) { return reinterpret_cast<std::uintptr_t>(place) % page; };
  char* const begin = static_cast<char*>(sbrk(0));
  mallopt(M_TOP_PAD, block);
  void* volatile some = std::malloc(page);  // the heap grows by both; volatile, or no compiler would ask for it
  std::free(some);
  mallopt(M_TOP_PAD, 1 << 20);
  char* const end = static_cast<char*>(sbrk(0));
  char* const first = begin + (page - beyond_page(begin)) % page;
  // A refusal changes nothing but the time it takes.
  if (first + page <= end)
    static_cast<void>(madvise(first, static_cast<std::size_t>(end - first) / page * page, MADV_HUGEPAGE));
#endif
}

}  // namespace decid::tools
