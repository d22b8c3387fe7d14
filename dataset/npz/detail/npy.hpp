// The header of a NumPy array file, text in and text out. Private to npz.cpp.
// Format: numpy.lib.format, versions 1.0 and 2.0: "\x93NUMPY", version, length of what follows (2 or 4 bytes, little
// endian), then a Python dictionary {'descr': '<f4', 'fortran_order': False, 'shape': (3, 4), }, padded with blanks.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace decid::dataset {

struct NpyHeader {
  std::string type;                ///< '<f4', '|S12', ...
  std::vector<std::size_t> shape;  ///< empty: a single value
  bool fortran_order = false;
  std::size_t bytes = 0;  ///< length of the header in the file, before the values
};

/// Returns a header of version 1.0 whose length is a multiple of 64, as NumPy aligns it.
std::string npy_header(const std::string& type, const std::vector<std::size_t>& shape);

/// Reads the header at the front of `content`. `where` names file and array in errors. Throws Error if it is missing,
/// cut off, or of a version other than 1.0 and 2.0.
NpyHeader parse_npy_header(std::string_view content, const std::string& where);

/// Returns the number of values, or a number larger than any memory if the product overflows.
std::size_t value_count(const std::vector<std::size_t>& shape);

}  // namespace decid::dataset
