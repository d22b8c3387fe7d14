// What a MAT-file holds, whichever reader found it: mat_5.hpp for versions 4 to 7, mat_73.hpp for 7.3.
// Not installed.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace decid::dataset {

struct MatVariable {
  enum class Kind { numbers, complex, text, cell, structure, sparse, object, function };

  std::string name;
  Kind kind = Kind::numbers;
  bool is_matrix = true;  ///< of two dimensions; height and width are 0 otherwise
  std::size_t height = 0, width = 0;
  std::vector<double> values = {};       ///< of numbers, column after column: height * width
  std::vector<MatVariable> fields = {};  ///< of a structure of 1 x 1
};

/// Structures within structures that are read.
inline constexpr int deepest_structure = 4;

/// Variables and fields of a file.
inline constexpr int most_mat_variables = 10'000;

/// How many numbers a file may hold, so that a small one cannot claim all of the memory: 32 million, or as many as it
/// has bytes, to 100 million.
constexpr std::size_t most_mat_values(std::size_t file_bytes) {
  constexpr std::size_t least = std::size_t{1} << 25, most = 100'000'000;
  return file_bytes < least ? least : file_bytes < most ? file_bytes : most;
}

}  // namespace decid::dataset
