// Arrays of numbers as an .npz file, which NumPy opens.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace decid::dataset {

struct NamedArray {
  std::string name;                ///< ASCII; of the file's member, without ".npy"
  std::vector<std::size_t> shape;  ///< its product is the number of values
  std::span<const double> values;  ///< the last index runs fastest
};

/// Writes them as float64, whole or not at all. Throws Error if the file cannot be written, or a shape is not that of
/// its values.
void write_arrays(const std::filesystem::path& path, std::span<const NamedArray> arrays);

}  // namespace decid::dataset
