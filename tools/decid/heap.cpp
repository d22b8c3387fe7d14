// The heap: see heap.hpp. Identifying one recording takes some 20 MB in blocks of up to 3 MB. By default the C library
// maps such blocks and returns them, and every page of 4 KB traps when it is touched. These settings save 18 of 63 ms
// from start to exit (EPYC Zen 3, fastest of 60 calls of decid identify). A sanitizer has its own heap.
#include "tools/decid/heap.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>

#if defined(__GLIBC__) && !defined(DECID_SANITIZED)
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace decid::tools {

void prepare_heap() {
#if defined(__GLIBC__) && !defined(DECID_SANITIZED)
  constexpr int block = 32 << 20;   // what the C library's own threshold grows to, in time
  constexpr int large = 128 << 20;  // of addresses, which cost nothing: the results of 400 recordings
  constexpr std::uintptr_t page = 2 << 20, least = 256 << 10, small_page = 4 << 10;
  mallopt(M_MMAP_THRESHOLD, block);
  mallopt(M_TRIM_THRESHOLD, large + 2 * block);
  // Eight cores share a heap, because only the first heap has large pages. Each thread caches small blocks itself. A
  // recording takes a few hundred large blocks, so threads seldom wait for each other.
  mallopt(M_ARENA_MAX, static_cast<int>(std::max(1L, sysconf(_SC_NPROCESSORS_ONLN) / 8)));
  char* const begin = static_cast<char*>(sbrk(0));  // the heap's end
  const std::uintptr_t to_page = page - reinterpret_cast<std::uintptr_t>(begin) % page;
  char* const first = begin + (to_page < least ? to_page + page : to_page);
  // Memory before the first large page stays unused, because it would be touched 4 KB at a time. The allocation is
  // larger than the rest of the heap, so the heap grows by the allocation and by `large`. It ends before the first
  // large page, which nothing has touched yet: the system does not enlarge a page that contains a touched small page.
  // Without volatile, the compiler could remove the unused allocation.
  mallopt(M_TOP_PAD, large);
  void* volatile unused = std::malloc(static_cast<std::size_t>(first - begin) - small_page);
  mallopt(M_TOP_PAD, 1 << 20);
  char* const end = static_cast<char*>(sbrk(0));
  // A failure costs only time.
  if (unused != nullptr && first + page <= end)
    static_cast<void>(madvise(first, static_cast<std::size_t>(end - first) / page * page, MADV_HUGEPAGE));
#endif
}

}  // namespace decid::tools
