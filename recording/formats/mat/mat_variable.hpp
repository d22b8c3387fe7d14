// What a MAT-file holds, whichever reader found it: mat_5.hpp for versions 4 to 7, mat_73.hpp for 7.3.
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
  bool is_matrix = true;  ///< of two or three dimensions; their sizes are 0, 0 and 1 otherwise
  std::size_t height = 0, width = 0, pages = 1;
  std::vector<double> values = {};     ///< of numbers, column after column, page after page: height * width * pages
  std::vector<std::string> text = {};  ///< of text its rows, without blanks at their ends; of an object its class
  /// Of a structure of 1 x 1 its fields. Of a larger one and of a cell array the elements in MATLAB's order, called
  /// "(1)" or "{1}"; those of a structure are structures of 1 x 1.
  std::vector<MatVariable> fields = {};

  std::size_t count() const { return height * width * pages; }
};

/// Levels of structures, arrays of them and cells within each other that are read.
inline constexpr int deepest_structure = 8;

/// Characters of all text of a file; what lies beyond is not read.
inline constexpr std::size_t max_mat_characters = 1'000'000;

/// The rows of a matrix of characters, column after column, without blanks and nulls at their ends.
std::vector<std::string> text_rows(const std::vector<std::uint32_t>& characters, std::size_t height, std::size_t width);

/// Variables and fields of a file.
inline constexpr int max_mat_variables = 10'000;

/// Columns of a file, those of all elements of its arrays together.
inline constexpr std::size_t max_mat_columns = 10'000;

/// How many numbers a file may hold, so that a small one cannot claim all of the memory: 32 million, or as many as it
/// has bytes, to 100 million.
constexpr std::size_t max_mat_values(std::size_t file_bytes) {
  constexpr std::size_t least = std::size_t{1} << 25, most = 100'000'000;
  return file_bytes < least ? least : file_bytes < most ? file_bytes : most;
}

}  // namespace decid::recording
