// The header of a NumPy array file: its dictionary is Python text, of which only NumPy's own form is read. Format:
// numpy.lib.format, versions 1.0 and 2.0.
#include "dataset/npz/detail/npy.hpp"

#include <charconv>
#include <limits>

#include "base/error.hpp"

namespace decid::dataset {

namespace {

constexpr std::string_view npy_magic = "\x93NUMPY";

/// Parses the dictionary; every step either takes the expected text or throws.
class Dictionary {
 public:
  Dictionary(std::string_view text, const std::string& where) : text_(text), where_(where) {}

  NpyHeader read() {
    NpyHeader header;
    bool has_type = false, has_order = false, has_shape = false;
    expect('{');
    while (!take('}')) {
      const std::string key = quoted();
      expect(':');
      if (key == "descr") {
        header.type = quoted();
        has_type = true;
      } else if (key == "fortran_order") {
        header.fortran_order = boolean();
        has_order = true;
      } else if (key == "shape") {
        header.shape = tuple();
        has_shape = true;
      } else {
        fail();
      }
      if (!take(',')) {
        expect('}');
        break;
      }
    }
    if (!has_type || !has_order || !has_shape) fail();
    return header;
  }

 private:
  [[noreturn]] void fail() const {
    throw Error(Code::file_damaged, where_,
                "its NumPy header is not of the form {'descr': '<f4', 'fortran_order': False, 'shape': (3, 4)}",
                "write the array with numpy.savez, without records or objects");
  }

  void skip_blanks() {
    while (!text_.empty() && (text_.front() == ' ' || text_.front() == '\n')) text_.remove_prefix(1);
  }

  bool take(char c) {
    skip_blanks();
    if (text_.empty() || text_.front() != c) return false;
    text_.remove_prefix(1);
    return true;
  }

  bool take(std::string_view word) {
    skip_blanks();
    if (!text_.starts_with(word)) return false;
    text_.remove_prefix(word.size());
    return true;
  }

  void expect(char c) {
    if (!take(c)) fail();
  }

  std::string quoted() {
    skip_blanks();
    const char quote = text_.empty() ? '\0' : text_.front();
    if (quote != '\'' && quote != '"') fail();
    const std::size_t end = text_.find(quote, 1);
    if (end == std::string_view::npos) fail();
    std::string content(text_.substr(1, end - 1));
    text_.remove_prefix(end + 1);
    return content;
  }

  bool boolean() {
    if (take(std::string_view("True"))) return true;
    if (take(std::string_view("False"))) return false;
    fail();
  }

  std::vector<std::size_t> tuple() {
    std::vector<std::size_t> values;
    expect('(');
    while (!take(')')) {
      skip_blanks();
      std::size_t value = 0;
      const auto [end, error] = std::from_chars(text_.data(), text_.data() + text_.size(), value);
      if (error != std::errc()) fail();
      text_.remove_prefix(static_cast<std::size_t>(end - text_.data()));
      values.push_back(value);
      if (!take(',')) {
        expect(')');
        break;
      }
    }
    return values;
  }

  std::string_view text_;
  const std::string& where_;
};

}  // namespace

std::string npy_header(const std::string& type, const std::vector<std::size_t>& shape) {
  std::string tuple;
  for (const std::size_t extent : shape) tuple += std::to_string(extent) + (shape.size() == 1 ? "," : ", ");
  if (shape.size() > 1) tuple.resize(tuple.size() - 2);
  std::string dictionary = "{'descr': '" + type + "', 'fortran_order': False, 'shape': (" + tuple + "), }";
  constexpr std::size_t fixed = npy_magic.size() + 4;  // version and length
  const std::size_t total = (fixed + dictionary.size() + 1 + 63) / 64 * 64;
  dictionary.append(total - fixed - dictionary.size() - 1, ' ') += '\n';
  std::string header(npy_magic);
  header += {'\x01', '\x00', static_cast<char>(dictionary.size() & 0xff), static_cast<char>(dictionary.size() >> 8)};
  return header + dictionary;
}

NpyHeader parse_npy_header(std::string_view content, const std::string& where) {
  const auto cut_off = [&] {
    return Error(Code::file_damaged, where, "its NumPy header is cut off", "make the file again");
  };
  if (!content.starts_with(npy_magic))
    throw Error(Code::file_damaged, where, "is not a NumPy array", "write it with numpy.savez");
  if (content.size() < npy_magic.size() + 2) throw cut_off();
  const auto byte = [&](std::size_t index) { return std::size_t{static_cast<unsigned char>(content[index])}; };
  const std::size_t major = byte(6), minor = byte(7);
  if ((major != 1 && major != 2) || minor != 0) {
    throw Error(Code::file_unsupported, where,
                "is of NumPy format " + std::to_string(major) + "." + std::to_string(minor),
                "write it in format 1.0 or 2.0");
  }
  const std::size_t length_bytes = major == 1 ? 2 : 4, fixed = 8 + length_bytes;
  if (content.size() < fixed) throw cut_off();
  std::size_t length = 0;
  for (std::size_t i = 0; i < length_bytes; ++i) length |= byte(8 + i) << (8 * i);
  if (content.size() - fixed < length) throw cut_off();
  NpyHeader header = Dictionary(content.substr(fixed, length), where).read();
  header.bytes = fixed + length;
  return header;
}

std::size_t value_count(const std::vector<std::size_t>& shape) {
  std::size_t count = 1;
  for (const std::size_t extent : shape) {
    if (extent != 0 && count > std::numeric_limits<std::size_t>::max() / extent) {
      return std::numeric_limits<std::size_t>::max();
    }
    count *= extent;
  }
  return count;
}

}  // namespace decid::dataset
