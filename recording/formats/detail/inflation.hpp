// A zlib stream that ends with its scope. Not installed.
#pragma once

#include <zlib.h>

#include <new>
#include <string_view>

namespace decid::recording {

struct Inflation {
  z_stream stream{};

  /// window_bits: as for zlib's inflateInit2, below 0 without zlib's header. Throws std::bad_alloc.
  Inflation(std::string_view packed, int window_bits) {
    if (inflateInit2(&stream, window_bits) != Z_OK) throw std::bad_alloc();
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
    stream.avail_in = static_cast<uInt>(packed.size());
  }
  ~Inflation() { inflateEnd(&stream); }
  Inflation(const Inflation&) = delete;
  Inflation& operator=(const Inflation&) = delete;
};

}  // namespace decid::recording
