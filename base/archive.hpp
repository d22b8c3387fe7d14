// Values as bytes, for ranks of one call and for journals: read by the version of decid that wrote them, on machines of
// one byte order. A type says its members once, for both directions:
//   template <class Archive> void archive(Archive& a, Point& point) { a(point.x, point.y); }
// or, with private members, as `template <class Archive> void archive(Archive& a)` of its own. Not installed.
#pragma once

#include <array>
#include <complex>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#include "base/error.hpp"

namespace decid {

template <class Value>
struct IsPlain
    : std::bool_constant<(std::is_arithmetic_v<Value> && !std::is_same_v<Value, bool>) || std::is_enum_v<Value>> {};
template <class Value>
struct IsPlain<std::complex<Value>> : std::true_type {};
template <class Value, std::size_t size>
struct IsPlain<std::array<Value, size>> : IsPlain<Value> {};

/// Appends values to `bytes`.
class ByteWriter {
 public:
  static constexpr bool reads = false;
  template <class... Values>
  void operator()(Values&... values);
  void raw(void* from, std::size_t size) { bytes.append(static_cast<const char*>(from), size); }
  std::size_t count(std::size_t size) {
    std::uint64_t wide = size;
    raw(&wide, sizeof wide);
    return size;
  }

  std::string bytes;
};

/// Reads them back in their order. Throws Error for bytes that end too early.
class ByteReader {
 public:
  static constexpr bool reads = true;
  explicit ByteReader(std::string_view bytes) : rest_(bytes) {}
  template <class... Values>
  void operator()(Values&... values);
  void raw(void* to, std::size_t size) {
    if (size > rest_.size()) fail();
    if (size > 0) std::memcpy(to, rest_.data(), size);
    rest_.remove_prefix(size);
  }
  /// The number of elements of a list, each of which takes a byte at least.
  std::size_t count(std::size_t) {
    std::uint64_t wide = 0;
    raw(&wide, sizeof wide);
    if (wide > rest_.size()) fail();
    return static_cast<std::size_t>(wide);
  }
  bool at_end() const noexcept { return rest_.empty(); }
  [[noreturn]] static void fail() {
    throw Error(Code::file_damaged, "stored values", "are cut off or of another version of decid", "make them again");
  }

 private:
  std::string_view rest_;
};

/// One value in either direction.
template <class Archive, class Value>
void archive_value(Archive& a, Value& value) {
  if constexpr (IsPlain<Value>::value) {
    a.raw(&value, sizeof value);
  } else if constexpr (std::is_same_v<Value, bool>) {
    auto byte = static_cast<std::uint8_t>(value ? 1 : 0);
    a.raw(&byte, 1);
    value = byte != 0;
  } else if constexpr (requires { value.archive(a); }) {
    value.archive(a);
  } else if constexpr (requires { value.resize(std::size_t{}); }) {
    const std::size_t size = a.count(value.size());
    using Element = typename Value::value_type;
    if constexpr (Archive::reads) value.resize(size);
    if constexpr (IsPlain<Element>::value)
      a.raw(value.data(), size * sizeof(Element));
    else
      for (Element& element : value) archive_value(a, element);
  } else {
    archive(a, value);
  }
}

template <class Archive, class Value>
void archive(Archive& a, std::optional<Value>& value) {
  bool there = value.has_value();
  a(there);
  if constexpr (Archive::reads) {
    value.reset();
    if (there) value.emplace();
  }
  if (value) a(*value);
}

template <class Archive>
void archive(Archive& a, std::optional<Error>& error) {
  std::array<std::string, 3> texts;
  if (error) texts = {error->where(), error->problem(), error->remedy()};
  bool there = error.has_value();
  a(there, texts[0], texts[1], texts[2]);
  if (!there) {
    error.reset();
    return;
  }
  Code code = error ? error->code() : Code::internal;
  a(code);
  if constexpr (Archive::reads) {
    if (code < Code{} || code > Code::internal) Archive::fail();
    error.emplace(code, texts[0], texts[1], texts[2]);
  }
}

template <class... Values>
void ByteWriter::operator()(Values&... values) {
  (archive_value(*this, values), ...);
}
template <class... Values>
void ByteReader::operator()(Values&... values) {
  (archive_value(*this, values), ...);
}

template <class Value>
std::string to_bytes(const Value& value) {
  ByteWriter writer;
  writer(const_cast<Value&>(value));  // a writer changes nothing
  return std::move(writer.bytes);
}
/// Throws Error for bytes that hold no such value, or more than it.
template <class Value>
Value from_bytes(std::string_view bytes) {
  Value value{};
  ByteReader reader(bytes);
  reader(value);
  if (!reader.at_end()) ByteReader::fail();
  return value;
}

}  // namespace decid
