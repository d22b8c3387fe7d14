// Variables of a MAT-file, independent of the reader: mat_5.hpp for versions 4 to 7, mat_73.hpp for 7.3.
// Not installed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace decid::recording {

struct MatVariable {
  enum class Kind { numbers, complex, text, cell, structure, sparse, object, function };

  std::string name;
  Kind kind = Kind::numbers;
  bool is_matrix = true;  ///< of two or three dimensions; otherwise the sizes are 0, 0 and 1
  std::size_t height = 0, width = 0, pages = 1;
  std::vector<double> values = {};     ///< numbers, column after column, page after page: height * width * pages
  std::vector<std::string> text = {};  ///< rows of text without trailing blanks, or the class of an object
  /// Fields of a 1 x 1 structure. A larger structure or a cell array has its elements in MATLAB's order, called "(1)"
  /// or "{1}"; elements of a structure are 1 x 1 structures.
  std::vector<MatVariable> fields = {};

  std::size_t count() const { return height * width * pages; }
};

/// The depth to which structures, arrays of structures and cells are read.
inline constexpr int deepest_structure = 8;

/// Characters of all text of a file; further text is not read.
inline constexpr std::size_t max_mat_characters = 1'000'000;

/// Returns the rows of a character matrix, column after column, without trailing blanks and nulls.
std::vector<std::string> text_rows(const std::vector<std::uint32_t>& characters, std::size_t height, std::size_t width);

/// The maximum number of variables and fields of a file.
inline constexpr int max_mat_variables = 10'000;

/// The maximum number of columns of a file, including all elements of its arrays.
inline constexpr std::size_t max_mat_columns = 10'000;

/// Returns the maximum number of values of a file, so that a small file cannot claim all memory: 32 million, or the
/// number of its bytes up to 100 million.
constexpr std::size_t max_mat_values(std::size_t file_bytes) {
  constexpr std::size_t min = std::size_t{1} << 25, max = 100'000'000;
  return file_bytes < min ? min : file_bytes < max ? file_bytes : max;
}

}  // namespace decid::recording
