// Version 7.3 by matio, in a child process: see mat_73.hpp. Matio's results are checked because a file may claim
// anything. The child's answer is checked again because the file may have taken over the child. The first such file
// loads matio, which loads HDF5 and 30 other libraries; loading them at every start would take time.
#include "recording/formats/detail/mat/mat_73.hpp"

#include <matio.h>

#include <cstdint>
#include <cstring>
#include <memory>

#include "base/error.hpp"
#include "base/files/shared_library.hpp"
#include "recording/formats/detail/child.hpp"

namespace decid::recording {
namespace {

/// The functions of matio used here. DECID_MATIO_SONAME: the name of the library that belongs to its header, with the
/// major version.
class Matio {
  SharedLibrary library_{DECID_MATIO_SONAME, "MAT-files of version 7.3", "need matio",
                         "install it (Debian: libmatio11), or save the file with '-v7', or as CSV"};

 public:
  decltype(&Mat_Open) open = library_.find<decltype(&Mat_Open)>("Mat_Open");
  decltype(&Mat_Close) close = library_.find<decltype(&Mat_Close)>("Mat_Close");
  decltype(&Mat_VarReadNextInfo) read_next_info = library_.find<decltype(&Mat_VarReadNextInfo)>("Mat_VarReadNextInfo");
  decltype(&Mat_VarReadDataAll) read_data_all = library_.find<decltype(&Mat_VarReadDataAll)>("Mat_VarReadDataAll");
  decltype(&Mat_VarGetNumberOfFields) number_of_fields =
      library_.find<decltype(&Mat_VarGetNumberOfFields)>("Mat_VarGetNumberOfFields");
  decltype(&Mat_VarFree) free = library_.find<decltype(&Mat_VarFree)>("Mat_VarFree");
};

/// Returns the functions, loaded once. Throws Error at each call if loading fails.
const Matio& matio() {
  static const Matio loaded;
  return loaded;
}

struct Close {
  void operator()(mat_t* file) const { matio().close(file); }
};
struct Free {
  void operator()(matvar_t* variable) const { matio().free(variable); }
};

template <class T>
std::vector<double> as_doubles(const void* data, std::size_t count) {
  const T* from = static_cast<const T*>(data);
  return std::vector<double>(from, from + count);
}

/// Returns `count` real numbers; nothing if the variable holds other data.
std::vector<double> numbers_of(const matvar_t& variable, std::size_t count) {
  if (variable.isComplex != 0 || variable.data == nullptr || variable.data_size <= 0) return {};
  if (variable.nbytes / static_cast<std::size_t>(variable.data_size) < count) return {};
  switch (variable.class_type) {
    case MAT_C_DOUBLE:
      return as_doubles<double>(variable.data, count);
    case MAT_C_SINGLE:
      return as_doubles<float>(variable.data, count);
    case MAT_C_INT8:
      return as_doubles<std::int8_t>(variable.data, count);
    case MAT_C_UINT8:
      return as_doubles<std::uint8_t>(variable.data, count);
    case MAT_C_INT16:
      return as_doubles<std::int16_t>(variable.data, count);
    case MAT_C_UINT16:
      return as_doubles<std::uint16_t>(variable.data, count);
    case MAT_C_INT32:
      return as_doubles<std::int32_t>(variable.data, count);
    case MAT_C_UINT32:
      return as_doubles<std::uint32_t>(variable.data, count);
    case MAT_C_INT64:
      return as_doubles<std::int64_t>(variable.data, count);
    case MAT_C_UINT64:
      return as_doubles<std::uint64_t>(variable.data, count);
    default:
      return {};
  }
}

MatVariable::Kind kind_of(const matvar_t& variable) {
  using Kind = MatVariable::Kind;
  switch (variable.class_type) {
    case MAT_C_CELL:
      return Kind::cell;
    case MAT_C_STRUCT:
      return Kind::structure;
    case MAT_C_CHAR:
      return Kind::text;
    case MAT_C_SPARSE:
      return Kind::sparse;
    case MAT_C_OBJECT:
    case MAT_C_OPAQUE:
      return Kind::object;
    case MAT_C_FUNCTION:
      return Kind::function;
    default:
      return variable.isComplex != 0 ? Kind::complex : Kind::numbers;
  }
}

/// The remaining limits of a file.
struct Left {
  std::size_t values, characters = max_mat_characters;
  int variables = max_mat_variables;
};

std::vector<std::string> to_text(const matvar_t& from, const MatVariable& made, Left& left) {
  const std::size_t count = made.count();
  if (made.pages != 1 || from.data == nullptr || from.data_size <= 0 || count > left.characters) return {};
  const auto each = static_cast<std::size_t>(from.data_size);
  if ((each != 1 && each != 2) || from.nbytes / each < count) return {};
  left.characters -= count;
  std::vector<std::uint32_t> characters;
  for (std::size_t i = 0; i < count; ++i)
    characters.push_back(each == 1 ? std::uint32_t{static_cast<const std::uint8_t*>(from.data)[i]}
                                   : std::uint32_t{static_cast<const std::uint16_t*>(from.data)[i]});
  return text_rows(characters, made.height, made.width);
}

MatVariable converted(const matvar_t& from, int depth, Left& left);

/// Returns `count` of the variables that `from` points to, beginning at `first`.
std::vector<MatVariable> inner_variables(const matvar_t& from, std::size_t first, std::size_t count, int depth,
                                         Left& left) {
  std::vector<MatVariable> made;
  const auto* const* inner = static_cast<matvar_t* const*>(from.data);
  const std::size_t all = from.nbytes / sizeof(void*);
  for (std::size_t i = first; i < first + count && i < all && left.variables > 0; ++i)
    made.push_back(inner[i] != nullptr ? converted(*inner[i], depth, left) : MatVariable());
  return made;
}

/// Converts the fields of a structure, and the elements of a larger structure or a cell array.
void convert_inner(const matvar_t& from, int depth, Left& left, MatVariable& made) {
  if (from.data == nullptr || depth >= deepest_structure) return;
  const std::size_t elements = made.count();
  if (made.kind == MatVariable::Kind::cell) {
    made.fields = inner_variables(from, 0, elements, depth + 1, left);
    for (std::size_t i = 0; i < made.fields.size(); ++i) made.fields[i].name = "{" + std::to_string(i + 1) + "}";
    return;
  }
  const std::size_t fields = matio().number_of_fields(const_cast<matvar_t*>(&from));
  if (elements == 1) {
    made.fields = inner_variables(from, 0, fields, depth + 1, left);
    return;
  }
  if (depth + 1 >= deepest_structure || fields == 0) return;
  for (std::size_t i = 0; i < elements && left.variables > 0; ++i) {
    --left.variables;
    made.fields.push_back({.name = "(" + std::to_string(i + 1) + ")",
                           .kind = MatVariable::Kind::structure,
                           .height = 1,
                           .width = 1,
                           .fields = inner_variables(from, i * fields, fields, depth + 2, left)});
  }
}

MatVariable converted(const matvar_t& from, int depth, Left& left) {
  using Kind = MatVariable::Kind;
  MatVariable made;
  --left.variables;
  made.name = from.name != nullptr ? from.name : "";
  made.kind = kind_of(from);
  made.is_matrix = (from.rank == 2 || from.rank == 3) && from.dims != nullptr;
  if (!made.is_matrix) return made;
  std::size_t count = 1;
  for (int d = 0; d < from.rank; ++d) {
    const std::size_t size = from.dims[d];
    (d == 0 ? made.height : d == 1 ? made.width : made.pages) = size;
    if (size != 0 && count > left.values / size) return made;
    count *= size;
  }
  if (made.kind == Kind::structure || made.kind == Kind::cell) {
    convert_inner(from, depth, left, made);
  } else if (made.kind == Kind::text) {
    made.text = to_text(from, made, left);
  } else {
    made.values = numbers_of(from, count);
    left.values -= made.values.size();
  }
  return made;
}

/// Runs in the child.
std::vector<MatVariable> read_by_matio(const std::string& path, std::size_t max_values) {
  Left left{.values = max_values};
  const std::unique_ptr<mat_t, Close> file(matio().open(path.c_str(), MAT_ACC_RDONLY));
  if (!file) throw Error(Code::file_damaged, path, "is not a MAT-file", "");
  std::vector<MatVariable> variables;
  // Sizes are checked before the values are read.
  while (const std::unique_ptr<matvar_t, Free> variable{matio().read_next_info(file.get())}) {
    std::size_t count = 1;
    for (int d = 0; d < variable->rank; ++d) {
      const std::size_t size = variable->dims[d];
      count = size != 0 && count > left.values / size ? left.values + 1 : count * size;
    }
    if (count > left.values) throw Error(Code::file_too_large, path, "claims too many values", "");
    // MATLAB ends the name of a class with a null. h5py pads it with nulls or omits it, so matio finds no class. HDF5
    // itself converts all kinds of numbers.
    const bool is_guess = variable->class_type == MAT_C_EMPTY && count > 0;
    if (is_guess) {
      variable->class_type = MAT_C_DOUBLE;
      variable->data_type = MAT_T_DOUBLE;
    }
    const bool is_array = variable->class_type == MAT_C_STRUCT || variable->class_type == MAT_C_CELL;
    const bool is_read = (is_array && count <= std::size_t{max_mat_variables}) || variable->class_type == MAT_C_CHAR ||
                         (variable->class_type >= MAT_C_DOUBLE && variable->class_type <= MAT_C_UINT64);
    if (is_read && matio().read_data_all(file.get(), variable.get()) != 0) {
      if (!is_guess) throw Error(Code::file_damaged, path, "is damaged", "");
      variable->class_type = MAT_C_OPAQUE;  // such as references; other variables may be readable
    }
    variables.push_back(converted(*variable, 0, left));
  }
  return variables;
}

void append_number(std::string& bytes, std::uint64_t number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

void append_text(std::string& bytes, const std::string& text) {
  append_number(bytes, text.size());
  bytes += text;
}

void append_variables(std::string& bytes, const std::vector<MatVariable>& variables) {
  append_number(bytes, variables.size());
  for (const MatVariable& variable : variables) {
    append_text(bytes, variable.name);
    append_number(bytes, static_cast<std::uint64_t>(variable.kind));
    append_number(bytes, variable.is_matrix ? 1 : 0);
    append_number(bytes, variable.height);
    append_number(bytes, variable.width);
    append_number(bytes, variable.pages);
    append_number(bytes, variable.values.size());
    bytes.append(reinterpret_cast<const char*>(variable.values.data()), variable.values.size() * sizeof(double));
    append_number(bytes, variable.text.size());
    for (const std::string& row : variable.text) append_text(bytes, row);
    append_variables(bytes, variable.fields);
  }
}

bool take_number(std::string_view& bytes, std::uint64_t& number) {
  if (bytes.size() < sizeof number) return false;
  std::memcpy(&number, bytes.data(), sizeof number);
  bytes.remove_prefix(sizeof number);
  return true;
}

bool take_text(std::string_view& bytes, std::string& text) {
  std::uint64_t length = 0;
  if (!take_number(bytes, length) || length > bytes.size()) return false;
  text = bytes.substr(0, length);
  bytes.remove_prefix(length);
  return true;
}

bool take_sizes(std::string_view& bytes, MatVariable& made) {
  std::uint64_t kind = 0, is_matrix = 0, height = 0, width = 0, pages = 0;
  for (std::uint64_t* number : {&kind, &is_matrix, &height, &width, &pages})
    if (!take_number(bytes, *number)) return false;
  if (kind > static_cast<std::uint64_t>(MatVariable::Kind::function) || is_matrix > 1) return false;
  made.kind = static_cast<MatVariable::Kind>(kind);
  made.is_matrix = is_matrix == 1;
  made.height = height;
  made.width = width;
  made.pages = pages;
  return true;
}

bool take_values(std::string_view& bytes, MatVariable& made) {
  std::uint64_t values = 0;
  if (!take_number(bytes, values) || values > bytes.size() / sizeof(double)) return false;
  std::uint64_t left = values;  // the largest allowed product of the remaining sizes
  for (const std::size_t size : {made.pages, made.width}) {
    if (values != 0 && (size == 0 || left % size != 0)) return false;
    if (values != 0) left /= size;
  }
  if (values != 0 && left != made.height) return false;
  made.values.resize(values);
  if (values != 0) std::memcpy(made.values.data(), bytes.data(), values * sizeof(double));
  bytes.remove_prefix(values * sizeof(double));
  return true;
}

bool take_variables(std::string_view& bytes, int depth, std::vector<MatVariable>& variables) {
  std::uint64_t count = 0, rows = 0;
  if (!take_number(bytes, count) || count > bytes.size() || (count > 0 && depth > deepest_structure)) return false;
  for (std::uint64_t i = 0; i < count; ++i) {
    MatVariable& made = variables.emplace_back();
    if (!take_text(bytes, made.name) || !take_sizes(bytes, made) || !take_values(bytes, made)) return false;
    if (!take_number(bytes, rows) || rows > bytes.size()) return false;
    for (std::uint64_t row = 0; row < rows; ++row)
      if (!take_text(bytes, made.text.emplace_back())) return false;
    if (!take_variables(bytes, depth + 1, made.fields)) return false;
  }
  return true;
}

}  // namespace

std::string to_bytes(const std::vector<MatVariable>& variables) {
  std::string bytes;
  append_variables(bytes, variables);
  return bytes;
}

bool from_bytes(std::string_view bytes, std::vector<MatVariable>& variables) {
  return take_variables(bytes, 0, variables) && bytes.empty();
}

std::vector<MatVariable> read_mat_73(const std::filesystem::path& path, std::size_t file_bytes) {
  constexpr std::size_t library_bytes = std::size_t{1} << 28;  // memory of HDF5 itself
  constexpr unsigned max_seconds = 30;
  const std::size_t max_values = max_mat_values(file_bytes);
  const std::string file = path.string();
  matio();  // here, because errors in the child are lost
  const auto answer = in_child([&] { return to_bytes(read_by_matio(file, max_values)); },
                               {library_bytes + 3 * sizeof(double) * max_values, max_seconds});
  std::vector<MatVariable> variables;
  if (!answer || !from_bytes(*answer, variables))
    throw Error(Code::file_damaged, file, "cannot be read: it is damaged, or far too large for a recording",
                "save it in MATLAB with save('file.mat', 'time', 'sway'), or as CSV");
  return variables;
}

}  // namespace decid::recording
