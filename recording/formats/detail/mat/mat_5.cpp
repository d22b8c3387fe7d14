// MAT-files of versions 5 to 7: see mat_5.hpp. A file may claim anything: every size is checked against the bytes
// present.
#include "recording/formats/detail/mat/mat_5.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <tuple>

#include "base/error.hpp"
#include "recording/formats/detail/inflation.hpp"
#include "recording/formats/detail/mat/mat_bytes.hpp"
#include "recording/table/table.hpp"

namespace decid::recording {
namespace {

constexpr std::size_t header_bytes = 128, tag_bytes = 8;

/// The format's numbers of the data element types used here.
enum : std::uint32_t {
  int8 = 1,
  uint8,
  int16,
  uint16,
  int32,
  uint32,
  single,
  double_precision = 9,
  int64 = 12,
  uint64,
  matrix,
  compressed,
  utf8,
  utf16,
  utf32
};

/// Reads files of version 5.
class Reader5 {
 public:
  Reader5(std::string_view file, const std::string& where)
      : where_(where),
        file_(file.substr(header_bytes), file[header_bytes - 2] != 'I', where),
        values_left_(max_mat_values(file.size())),
        inflated_left_(std::max<std::size_t>(std::size_t{1} << 27, 8 * file.size())) {}

  std::vector<MatVariable> read() {
    std::vector<MatVariable> variables;
    while (file_.left() > 0) {
      const Element element = next(file_);
      if (element.type == compressed) {
        const std::string inflated = inflated_matrix(element.data);
        MatBytes inside(inflated, file_.swapped(), where_);
        if (!inflated.empty()) add(next(inside), variables);
      } else {
        add(element, variables);
      }
    }
    return variables;
  }

 private:
  struct Element {
    std::uint32_t type;
    std::string_view data;
  };

  /// Returns the next element, without its padding.
  Element next(MatBytes& from) const {
    const auto type = from.number<std::uint32_t>();
    if (type >> 16 != 0) {  // a small element: its size follows its type, its data lie in the tag
      const std::string_view data = from.take(4);
      if (type >> 16 > 4) refuse_damaged(where_, "");
      return {type & 0xffff, data.substr(0, type >> 16)};
    }
    const auto size = from.number<std::uint32_t>();
    const std::string_view data = from.take(size);
    if (type != compressed) from.pass_at_most((tag_bytes - size % tag_bytes) % tag_bytes);
    return {type, data};
  }

  void add(const Element& element, std::vector<MatVariable>& variables) {
    if (element.type != matrix) return;
    MatVariable variable = read_matrix(element.data, 0);
    if (!variable.name.empty())
      variables.push_back(std::move(variable));  // MATLAB stores its own objects in a nameless one
  }

  /// Returns the matrix compressed in `bytes`, with its tag in front; empty if it is something else. Takes only the
  /// memory that the tag states.
  std::string inflated_matrix(std::string_view bytes) {
    Inflation inflation(bytes, MAX_WBITS);
    z_stream& stream = inflation.stream;
    std::string inflated(tag_bytes, '\0');
    const auto fill = [&](std::size_t begin) {
      stream.next_out = reinterpret_cast<Bytef*>(inflated.data() + begin);
      stream.avail_out = static_cast<uInt>(inflated.size() - begin);
      const int status = inflate(&stream, Z_SYNC_FLUSH);
      if (stream.avail_out != 0) refuse_damaged(where_, ", in its compressed data");
      return status;
    };
    int status = fill(0);
    MatBytes tag(inflated, file_.swapped(), where_);
    const auto type = tag.number<std::uint32_t>(), size = tag.number<std::uint32_t>();
    if (type != matrix) return {};
    if (size > inflated_left_)
      throw Error(Code::file_too_large, where_, "is far too large, decompressed, for a recording",
                  "save only one trial");
    inflated_left_ -= size;
    inflated.resize(tag_bytes + size);
    if (size > 0) status = fill(tag_bytes);
    // Padding and the checksum may follow.
    Bytef padding[tag_bytes];
    stream.next_out = padding;
    stream.avail_out = sizeof padding;
    if (status == Z_OK) status = inflate(&stream, Z_FINISH);
    if (status != Z_STREAM_END) refuse_damaged(where_, ", in its compressed data");
    return inflated;
  }

  /// `depth`: the number of structures around the matrix.
  MatVariable read_matrix(std::string_view bytes, int depth) {
    MatVariable variable;
    if (--variables_left_ < 0)
      throw Error(Code::file_too_large, where_, "holds more than 10000 variables", "save only one trial");
    if (bytes.empty()) return variable;  // an empty field
    MatBytes from(bytes, file_.swapped(), where_);
    const Element flags = next(from);
    if (flags.type != uint32 || flags.data.size() < 4) refuse_damaged(where_, "");
    const auto word = MatBytes(flags.data, file_.swapped(), where_).number<std::uint32_t>();
    const std::uint32_t kind = word & 0xff;
    if (kind == 17) {  // one of MATLAB's own objects: its name, kind and class; the rest is ignored
      variable.name = text(next(from).data);
      variable.kind = MatVariable::Kind::object;
      if (from.left() > 0) next(from);
      if (from.left() > 0) read_class(from, variable);
      return variable;
    }
    read_size(next(from), variable);
    variable.name = text(next(from).data);
    variable.kind = kind_of(kind, (word & 0x0800) != 0);
    using Kind = MatVariable::Kind;
    if (variable.kind == Kind::object && from.left() > 0) read_class(from, variable);
    if (variable.kind == Kind::text && from.left() > 0) read_text(next(from), variable);
    if (variable.kind == Kind::structure && depth < deepest_structure) read_fields(from, variable, depth);
    if (variable.kind == Kind::cell && depth < deepest_structure) read_cells(from, variable, depth);
    if (variable.kind == Kind::numbers && variable.is_matrix) read_values(from, variable);
    return variable;
  }

  void read_size(const Element& element, MatVariable& variable) const {
    if (element.type != int32) refuse_damaged(where_, "");
    const std::size_t dimensions = element.data.size() / sizeof(std::int32_t);
    variable.is_matrix = dimensions == 2 || dimensions == 3;
    if (!variable.is_matrix) return;
    MatBytes from(element.data, file_.swapped(), where_);
    for (std::size_t* size : {&variable.height, &variable.width, &variable.pages}) {
      if (from.left() < sizeof(std::int32_t)) return;
      const auto number = from.number<std::int32_t>();
      if (number < 0) refuse_damaged(where_, "");
      *size = static_cast<std::size_t>(number);
    }
  }

  /// Returns whether an array has at most this many elements; the comparison cannot overflow.
  static bool has_at_most(const MatVariable& variable, std::size_t max) {
    const auto& [height, width, pages] = std::tie(variable.height, variable.width, variable.pages);
    if (height == 0 || width == 0 || pages == 0) return true;
    return width <= max / height && pages <= max / height / width;
  }

  void read_class(MatBytes& from, MatVariable& variable) const {
    const Element name = next(from);
    if (name.type == int8 && name.data.size() <= max_name_bytes) variable.text = {text(name.data)};
  }

  void read_text(const Element& element, MatVariable& variable) {
    if (!variable.is_matrix || variable.pages != 1 || !has_at_most(variable, characters_left_)) return;
    std::vector<std::uint32_t> characters;
    MatBytes data(element.data, file_.swapped(), where_);
    const bool is_wide = element.type == utf16 || element.type == uint16, is_widest = element.type == utf32;
    const std::size_t each = is_widest ? 4 : is_wide ? 2 : 1;
    while (data.left() >= each && characters.size() < variable.count())
      characters.push_back(is_widest ? data.number<std::uint32_t>()
                           : is_wide ? data.number<std::uint16_t>()
                                     : character_8(data, element.type == utf8));
    if (characters.size() < variable.count()) return;
    characters_left_ -= characters.size();
    variable.text = text_rows(characters, variable.height, variable.width);
  }

  /// Returns a character of one byte, or of up to four in UTF-8.
  static std::uint32_t character_8(MatBytes& data, bool is_utf8) {
    const std::uint32_t first = data.number<std::uint8_t>();
    if (!is_utf8 || first < 0xC0) return first;
    int more = first >= 0xF0 ? 3 : first >= 0xE0 ? 2 : 1;
    std::uint32_t character = first & (0x3Fu >> more);
    for (; more > 0 && data.left() > 0; --more) character = character << 6 | (data.number<std::uint8_t>() & 0x3Fu);
    return character;
  }

  std::string text(std::string_view data) const {
    if (data.size() > max_name_bytes) refuse_damaged(where_, ", in a name");
    return std::string(data.substr(0, data.find('\0')));
  }

  MatVariable::Kind kind_of(std::uint32_t number, bool is_complex) const {
    using Kind = MatVariable::Kind;
    constexpr Kind kinds[]{Kind::cell, Kind::structure, Kind::object, Kind::text, Kind::sparse};
    if (number == 0 || number > 16) refuse_damaged(where_, "");
    if (number <= std::size(kinds)) return kinds[number - 1];
    if (number == 16) return Kind::function;
    return is_complex ? Kind::complex : Kind::numbers;
  }

  void read_fields(MatBytes& from, MatVariable& variable, int depth) {
    const Element length = next(from), names = next(from);
    if (length.type != int32) refuse_damaged(where_, "");
    const auto each = MatBytes(length.data, file_.swapped(), where_).number<std::int32_t>();
    if (each <= 0 || !variable.is_matrix) return;
    const auto size = static_cast<std::size_t>(each);
    const std::size_t fields = names.data.size() / size;
    if (fields == 0 || !has_at_most(variable, std::size_t{max_mat_variables})) return;
    const auto read_one = [&](MatVariable& structure, int its_depth) {
      for (std::size_t i = 0; i < fields && from.left() > 0; ++i) {
        const Element field = next(from);
        if (field.type != matrix) refuse_damaged(where_, "");
        structure.fields.push_back(read_matrix(field.data, its_depth + 1));
        structure.fields.back().name = text(names.data.substr(i * size, size));
      }
    };
    const std::size_t elements = variable.count();
    if (elements == 1) return read_one(variable, depth);
    if (depth + 1 >= deepest_structure || !may_hold(elements * (fields + 1))) return;
    variables_left_ -= static_cast<int>(elements);
    for (std::size_t i = 0; i < elements && from.left() > 0; ++i) {
      variable.fields.push_back(
          {.name = "(" + std::to_string(i + 1) + ")", .kind = MatVariable::Kind::structure, .height = 1, .width = 1});
      read_one(variable.fields.back(), depth + 1);
    }
  }

  void read_cells(MatBytes& from, MatVariable& variable, int depth) {
    if (!variable.is_matrix || !has_at_most(variable, std::size_t{max_mat_variables})) return;
    const std::size_t elements = variable.count();
    if (!may_hold(elements)) return;
    for (std::size_t i = 0; i < elements && from.left() > 0; ++i) {
      const Element cell = next(from);
      if (cell.type != matrix) refuse_damaged(where_, "");
      variable.fields.push_back(read_matrix(cell.data, depth + 1));
      variable.fields.back().name = "{" + std::to_string(i + 1) + "}";
    }
  }

  /// Returns false for large arrays of structures or cells (events, texts), which are skipped instead of refused.
  bool may_hold(std::size_t variables) const {
    return variables <= static_cast<std::size_t>(std::max(variables_left_, 0)) / 2;
  }

  void read_values(MatBytes& from, MatVariable& variable) {
    if (variable.height == 0 || variable.width == 0 || variable.pages == 0) return;
    if (!has_at_most(variable, values_left_))
      throw Error(Code::file_too_large, where_, variable.name + " claims too many values", "save only one trial");
    if (std::max({variable.height, variable.width, variable.pages}) > max_rows)
      throw Error(Code::file_too_large, where_, variable.name + " has more than 10 million values",
                  "cut it to one trial");
    const std::size_t count = variable.count();
    const Element element = next(from);
    MatBytes data(element.data, file_.swapped(), where_);
    const auto read = [&]() -> std::vector<double> {
      switch (element.type) {
        case int8:
          return data.numbers<std::int8_t>(count);
        case uint8:
          return data.numbers<std::uint8_t>(count);
        case int16:
          return data.numbers<std::int16_t>(count);
        case uint16:
          return data.numbers<std::uint16_t>(count);
        case int32:
          return data.numbers<std::int32_t>(count);
        case uint32:
          return data.numbers<std::uint32_t>(count);
        case single:
          return data.numbers<float>(count);
        case double_precision:
          return data.numbers<double>(count);
        case int64:
          return data.numbers<std::int64_t>(count);
        case uint64:
          return data.numbers<std::uint64_t>(count);
        default:
          refuse_damaged(where_, "");
      }
    };
    variable.values = read();
    values_left_ -= count;
  }

  const std::string& where_;
  MatBytes file_;
  std::size_t values_left_, inflated_left_, characters_left_ = max_mat_characters;
  int variables_left_ = max_mat_variables;
};

}  // namespace

MatVersion mat_version(std::string_view bytes) {
  if (bytes.size() >= header_bytes) {
    const std::string_view end = bytes.substr(header_bytes - 4, 4);
    if (end == std::string_view("\x00\x01IM", 4) || end == std::string_view("\x01\x00MI", 4)) return MatVersion::v5;
    if (end == std::string_view("\x00\x02IM", 4) || end == std::string_view("\x02\x00MI", 4)) return MatVersion::v73;
  }
  if (bytes.size() < 20) return MatVersion::none;
  return is_mat_4(bytes) ? MatVersion::v4 : MatVersion::none;
}

std::vector<MatVariable> read_mat_5(std::string_view bytes, const std::string& where) {
  return Reader5(bytes, where).read();
}

}  // namespace decid::recording
