// Memory aligned to cache lines and the widest vector registers.
#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace decid {

template <class T>
struct AlignedAllocator {
  using value_type = T;
  static constexpr std::align_val_t alignment{64};

  AlignedAllocator() = default;
  template <class U>
  AlignedAllocator(const AlignedAllocator<U>&) noexcept {}
  T* allocate(std::size_t count) { return static_cast<T*>(::operator new(count * sizeof(T), alignment)); }
  void deallocate(T* memory, std::size_t) noexcept { ::operator delete(memory, alignment); }
  template <class U>
  friend bool operator==(const AlignedAllocator&, const AlignedAllocator<U>&) noexcept {
    return true;
  }
};

/// A vector whose first value is aligned to 64 bytes.
template <class T>
using AlignedVector = std::vector<T, AlignedAllocator<T>>;

/// Leaves new values uninitialised.
template <class T>
struct WorkAllocator : AlignedAllocator<T> {
  WorkAllocator() = default;
  template <class U>
  WorkAllocator(const WorkAllocator<U>&) noexcept {}
  template <class U>
  void construct(U* place) noexcept {
    ::new (static_cast<void*>(place)) U;
  }
};

/// The same for work space that is overwritten before it is read: setting megabytes to zero takes as long as using
/// them.
template <class T>
using WorkVector = std::vector<T, WorkAllocator<T>>;

}  // namespace decid
