// Protocol Buffers, as much as an ONNX file needs: a message is its fields one after the other, each a key and a value.
// Format: https://protobuf.dev/programming-guides/encoding
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace decid::tools {

class Message {
 public:
  /// int32, int64, enumerations.
  Message& add(int field, long long value) {
    varint(key(field, 0));
    varint(static_cast<std::uint64_t>(value));
    return *this;
  }
  Message& add(int field, float value) {
    static_assert(std::endian::native == std::endian::little);
    varint(key(field, 5));
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes_.append(raw, sizeof raw);
    return *this;
  }
  /// Texts and raw bytes.
  Message& add(int field, std::string_view bytes) {
    varint(key(field, 2));
    varint(bytes.size());
    bytes_.append(bytes);
    return *this;
  }
  Message& add(int field, const Message& message) { return add(field, std::string_view(message.bytes_)); }

  const std::string& bytes() const { return bytes_; }

 private:
  static std::uint64_t key(int field, int wire_type) { return static_cast<std::uint64_t>(field << 3 | wire_type); }
  void varint(std::uint64_t value) {
    for (; value > 127; value >>= 7) bytes_ += static_cast<char>(value | 128);
    bytes_ += static_cast<char>(value);
  }

  std::string bytes_;
};

}  // namespace decid::tools
