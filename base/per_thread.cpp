// Objects per thread: see per_thread.hpp. A page (WebAssembly) has one thread, whose objects stay to its end.
#include "base/per_thread.hpp"

#include <new>

#ifndef __wasm__
#include <pthread.h>

#include <type_traits>

static_assert(std::is_same_v<pthread_key_t, unsigned>);
#endif

namespace decid {

#ifdef __wasm__
ThreadKey::ThreadKey(void (*)(void*)) {}
ThreadKey::~ThreadKey() = default;
void ThreadKey::put(void*) const {}
#else
ThreadKey::ThreadKey(void (*destroy)(void*)) {
  if (pthread_key_create(&key_, destroy) != 0) throw std::bad_alloc();
}

ThreadKey::~ThreadKey() {
  pthread_key_delete(key_);
}

void ThreadKey::put(void* object) const {
  if (pthread_setspecific(key_, object) != 0) throw std::bad_alloc();
}
#endif

}  // namespace decid
