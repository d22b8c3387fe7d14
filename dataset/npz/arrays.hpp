// Arrays of numbers as an .npz file, which NumPy opens.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace decid::dataset {

struct NamedArray {
  std::string name;                ///< ASCII; the name of the file's member, without ".npy"
  std::vector<std::size_t> shape;  ///< its product is the number of values
  std::span<const double> values;  ///< the last index varies fastest
};

/// Writes float64 arrays, completely or not at all. Throws Error if the file cannot be written, or a shape does not
/// match its values.
void write_arrays(const std::filesystem::path& path, std::span<const NamedArray> arrays);

/// Writes arrays that are too large for memory, of other types too: one after the other, each in pieces. The file
/// exists only after commit().
class ArrayWriter {
 public:
  /// Throws Error if the file cannot be written, or is not a regular file.
  explicit ArrayWriter(const std::filesystem::path& path);
  ~ArrayWriter();
  ArrayWriter(const ArrayWriter&) = delete;
  ArrayWriter& operator=(const ArrayWriter&) = delete;

  /// Begins an array of Value: float, double or std::uint8_t. name: ASCII.
  template <class Value>
  void begin(const std::string& name, const std::vector<std::size_t>& shape);
  /// Appends the array's next values. After all values of its shape, call begin(), add_text() or commit().
  template <class Value>
  void write(std::span<const Value> values) {
    write_bytes(std::as_bytes(values));
  }
  /// Adds an array of one text.
  void add_text(const std::string& name, const std::string& text);
  void commit();

 private:
  void write_bytes(std::span<const std::byte> bytes);
  void end();

  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace decid::dataset
