// A shared library that is loaded on demand. If it were linked, the loader would map and relocate it and its
// dependencies at every start of a program: matio with HDF5 7 ms, libzip 1.6 ms (EPYC Zen 3; an empty program linked
// with each).
#pragma once

#ifndef __wasm__
#include <dlfcn.h>
#endif

#include <new>
#include <string>
#include <string_view>
#include <utility>

#include "base/error.hpp"

namespace decid {

class SharedLibrary {
 public:
  /// file: its name, with the major version. The other arguments form an Error: where, the need ("need matio"), and the
  /// remedy. Throws std::bad_alloc if there is no memory to load it.
  SharedLibrary(const char* file, std::string where, std::string need, std::string remedy)
      : where_(std::move(where)), need_(std::move(need)), remedy_(std::move(remedy)) {
#ifndef __wasm__  // a page loads no libraries
    library_ = ::dlopen(file, RTLD_NOW | RTLD_LOCAL);
    if (library_ == nullptr) refuse(::dlerror());
#else
    refuse(file);
#endif
  }

  /// Returns a function that the library's header declares. Throws Error if the library lacks it.
  template <class Function>
  Function find(const char* name) const {
#ifndef __wasm__
    if (void* const found = ::dlsym(library_, name)) return reinterpret_cast<Function>(found);
#endif
    refuse(name);
  }

 private:
  [[noreturn]] void refuse(const char* why) const {
    const std::string_view reason = why != nullptr ? why : "";
    for (const char* no_memory :
         {"failed to map segment", "annot allocate memory"})  // glibc's text; musl has only strerror's
      if (reason.find(no_memory) != std::string_view::npos) throw std::bad_alloc();
    throw Error(Code::not_supported, where_, need_ + ", which cannot be loaded: " + std::string(reason), remedy_);
  }

  [[maybe_unused]] void* library_ = nullptr;  // a page has none
  std::string where_, need_, remedy_;
};

}  // namespace decid
