// An object of each thread's own. A thread_local with a destructor would do, but glibc registers destructors with
// memory that it must get: where there is none it ends the process, and with it whoever uses the library.
#pragma once

#include <memory>

namespace decid {

/// What destroys objects as their threads end.
class ThreadKey {
 public:
  /// Throws std::bad_alloc if the system has no key left.
  explicit ThreadKey(void (*destroy)(void*));
  ~ThreadKey();
  ThreadKey(const ThreadKey&) = delete;
  ThreadKey& operator=(const ThreadKey&) = delete;

  /// `object` is destroyed with the calling thread. Throws std::bad_alloc.
  void put(void* object) const;

 private:
  unsigned key_ = 0;
};

/// The calling thread's T: made at the thread's first call, destroyed with the thread, the main thread's with the
/// program. One for each T, so give it a type that its user alone knows. A call from what else the thread destroys at
/// its end makes another, which goes as well. Throws std::bad_alloc.
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
