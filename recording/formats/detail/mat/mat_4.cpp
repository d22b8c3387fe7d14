// MAT-files of version 4: see mat_5.hpp. A file may claim anything: every size is checked against the bytes present.
#include <cstdint>

#include "base/error.hpp"
#include "recording/formats/detail/mat/mat_5.hpp"
#include "recording/formats/detail/mat/mat_bytes.hpp"

namespace decid::recording {
namespace {

/// Returns true for the first number of a variable of version 4. Its digits are byte order, 0, number type and matrix
/// kind.
bool is_type_4(std::uint32_t type) {
  return type / 1000 <= 1 && type / 100 % 10 == 0 && type / 10 % 10 <= 5 && type % 10 <= 2;
}

std::uint32_t first_number(std::string_view bytes, bool swapped) {
  const std::string none;
  return MatBytes(bytes.substr(0, 4), swapped, none).number<std::uint32_t>();
}

std::vector<double> numbers_4(MatBytes& from, std::uint32_t precision, std::size_t count) {
  switch (precision) {
    case 0:
      return from.numbers<double>(count);
    case 1:
      return from.numbers<float>(count);
    case 2:
      return from.numbers<std::int32_t>(count);
    case 3:
      return from.numbers<std::int16_t>(count);
    case 4:
      return from.numbers<std::uint16_t>(count);
    default:
      return from.numbers<std::uint8_t>(count);
  }
}

}  // namespace

bool is_mat_4(std::string_view bytes) {
  return is_type_4(first_number(bytes, false)) || is_type_4(first_number(bytes, true));
}

std::vector<MatVariable> read_mat_4(std::string_view bytes, const std::string& where) {
  std::vector<MatVariable> variables;
  MatBytes from(bytes, !is_type_4(first_number(bytes, false)), where);
  std::size_t values_left = max_mat_values(bytes.size()), characters_left = max_mat_characters;
  while (from.left() > 0) {
    const auto type = from.number<std::uint32_t>(), height = from.number<std::uint32_t>();
    const auto width = from.number<std::uint32_t>(), imaginary = from.number<std::uint32_t>();
    const auto name_bytes = from.number<std::uint32_t>();
    if (!is_type_4(type)) refuse_damaged(where, "");
    if (variables.size() == std::size_t{max_mat_variables})
      throw Error(Code::file_too_large, where, "holds more than 10000 variables", "save only one trial");
    MatVariable variable;
    if (name_bytes > max_name_bytes) refuse_damaged(where, ", in a name");
    const std::string_view name = from.take(name_bytes);
    variable.name = name.substr(0, name.find('\0'));
    variable.height = height;
    variable.width = width;
    if (width != 0 && height > values_left / width)
      throw Error(Code::file_too_large, where, variable.name + " claims too many values", "save only one trial");
    const std::size_t count = variable.height * width;
    using Kind = MatVariable::Kind;
    variable.kind = type % 10 == 1   ? Kind::text
                    : type % 10 == 2 ? Kind::sparse
                    : imaginary != 0 ? Kind::complex
                                     : Kind::numbers;
    variable.values = numbers_4(from, type / 10 % 10, count);
    if (imaginary != 0) numbers_4(from, type / 10 % 10, count);
    if (variable.kind == Kind::text && count <= characters_left) {
      characters_left -= count;
      std::vector<std::uint32_t> characters;
      for (const double value : variable.values)
        characters.push_back(value >= 0.0 && value < 1e6 ? static_cast<std::uint32_t>(value) : std::uint32_t{'?'});
      variable.text = text_rows(characters, variable.height, variable.width);
    }
    if (variable.kind != Kind::numbers) variable.values.clear();
    values_left -= variable.values.size();
    variables.push_back(std::move(variable));
  }
  return variables;
}

}  // namespace decid::recording
