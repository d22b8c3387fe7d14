// An object per thread. glibc allocates memory to register the destructor of a thread_local, and ends the process if
// there is none, together with the library's user. This header avoids that.
#pragma once

#include <memory>

namespace decid {

/// Destroys objects when their threads end.
class ThreadKey {
 public:
  /// Throws std::bad_alloc if the system has no key left.
  explicit ThreadKey(void (*destroy)(void*));
  ~ThreadKey();
  ThreadKey(const ThreadKey&) = delete;
  ThreadKey& operator=(const ThreadKey&) = delete;

  /// Makes `object` end with the calling thread. Throws std::bad_alloc.
  void put(void* object) const;

 private:
  unsigned key_ = 0;
};

/// Returns the calling thread's T. It is made at the thread's first call and destroyed with the thread, the main
/// thread's with the program. There is one for each T, so use a type that only the caller knows. A call during the
/// thread's destruction makes another, which is destroyed too. Throws std::bad_alloc.
template <class T>
T& per_thread() {
  thread_local T* own = nullptr;
  if (own == nullptr) {
    static const ThreadKey key([](void* object) {
      own = nullptr;
      delete static_cast<T*>(object);
    });
    auto made = std::make_unique<T>();
    key.put(made.get());
    own = made.release();
  }
  return *own;
}

}  // namespace decid
