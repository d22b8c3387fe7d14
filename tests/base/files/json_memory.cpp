// JSON without memory (base/files/json_object.hpp). Replaces operator new, so it stands in no namespace.
#include <doctest/doctest.h>

#include <cstdlib>
#include <new>

#include "base/files/json_object.hpp"

// Not with sanitizers, which have operators of their own, nor with the library's assertions, which refuse such values.
#if defined(NDEBUG) && !defined(DECID_SANITIZED)
static thread_local long left_allocations = -1;  // until one fails; negative: none does

// Not inlined: see tests/nn/training/trainer.cpp.
[[gnu::noinline]] void* operator new(std::size_t size) {
  if (left_allocations < 0 || left_allocations-- > 0)
    if (void* p = std::malloc(size > 0 ? size : 1)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* p) noexcept {
  std::free(p);
}
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept {
  std::free(p);
}

TEST_CASE("a null without memory to become an object or a list is destroyed as a null") {
  bool is_whole = false;
  long index = 0;
  for (; !is_whole; ++index) {
    left_allocations = index;
    try {
      decid::Json json;
      json["figures"]["a key that is too long for a small string"] = 0.5;
      json["list"].push_back("a text that is too long for a small string");
      is_whole = true;
    } catch (const std::bad_alloc&) {
    }
    left_allocations = -1;
  }
  CHECK(index > 6);  // an object, a list or a text each
}
#endif
