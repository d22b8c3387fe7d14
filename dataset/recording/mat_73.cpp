// Version 7.3 by matio, in a child: see mat_73.hpp. What matio returns is checked before it is used, since a file may
// claim anything; what the child answers is checked again, since the file may have made the child its own. matio is
// loaded with the first such file: it brings HDF5 and 30 libraries more, which every other start would wait for.
#include "dataset/recording/mat_73.hpp"

#include <matio.h>

#include <cstdint>
#include <cstring>
#include <memory>

#include "base/error.hpp"
#include "base/shared_library.hpp"
#include "dataset/recording/child.hpp"

namespace decid::dataset {
namespace {

/// The functions of matio that are called here. DECID_MATIO_SONAME: the name of the library that its header was found
/// with, major version included.
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

/// Loaded once; throws Error, at each call, if it cannot be.
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

/// Empty if they are not `count` real numbers.
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

MatVariable converted(const matvar_t& from, int depth, std::size_t& values_left) {
  MatVariable made;
  made.name = from.name != nullptr ? from.name : "";
  made.kind = kind_of(from);
  made.is_matrix = from.rank == 2 && from.dims != nullptr;
  if (!made.is_matrix) return made;
  made.height = from.dims[0];
  made.width = from.dims[1];
  if (made.kind == MatVariable::Kind::structure) {
    if (made.height != 1 || made.width != 1 || depth >= deepest_structure || from.data == nullptr) return made;
    const auto* const* fields = static_cast<matvar_t* const*>(from.data);
    const unsigned count = matio().number_of_fields(const_cast<matvar_t*>(&from));
    for (unsigned i = 0; i < count && i * sizeof(void*) < from.nbytes; ++i)
      if (fields[i] != nullptr) made.fields.push_back(converted(*fields[i], depth + 1, values_left));
  } else if (made.width != 0 && made.height <= values_left / made.width) {
    made.values = numbers_of(from, made.height * made.width);
    values_left -= made.values.size();
  }
  return made;
}

/// In the child.
std::vector<MatVariable> read_by_matio(const std::string& path, std::size_t values_left) {
  const std::unique_ptr<mat_t, Close> file(matio().open(path.c_str(), MAT_ACC_RDONLY));
  if (!file) throw Error(path, "is not a MAT-file", "");
  std::vector<MatVariable> variables;
  // Sizes are checked before the values are read.
  while (const std::unique_ptr<matvar_t, Free> variable{matio().read_next_info(file.get())}) {
    std::size_t count = 1;
    for (int d = 0; d < variable->rank; ++d) {
      const std::size_t size = variable->dims[d];
      count = size != 0 && count > values_left / size ? values_left + 1 : count * size;
    }
    if (count > values_left) throw Error(path, "claims too many values", "");
    // h5py pads the name of the class with nulls where MATLAB ends it with one, or leaves it out; matio then knows no
    // class. HDF5 itself converts whatever numbers there are.
    if (variable->class_type == MAT_C_EMPTY && count > 0) {
      variable->class_type = MAT_C_DOUBLE;
      variable->data_type = MAT_T_DOUBLE;
    }
    const bool may_hold_numbers = variable->class_type == MAT_C_STRUCT ||
                                  (variable->class_type >= MAT_C_DOUBLE && variable->class_type <= MAT_C_UINT64);
    if (may_hold_numbers && matio().read_data_all(file.get(), variable.get()) != 0) throw Error(path, "is damaged", "");
    variables.push_back(converted(*variable, 0, values_left));
  }
  return variables;
}

void append_number(std::string& bytes, std::uint64_t number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

void append_variables(std::string& bytes, const std::vector<MatVariable>& variables) {
  append_number(bytes, variables.size());
  for (const MatVariable& variable : variables) {
    append_number(bytes, variable.name.size());
    bytes += variable.name;
    append_number(bytes, static_cast<std::uint64_t>(variable.kind));
    append_number(bytes, variable.is_matrix ? 1 : 0);
    append_number(bytes, variable.height);
    append_number(bytes, variable.width);
    append_number(bytes, variable.values.size());
    bytes.append(reinterpret_cast<const char*>(variable.values.data()), variable.values.size() * sizeof(double));
    append_variables(bytes, variable.fields);
  }
}

bool take_number(std::string_view& bytes, std::uint64_t& number) {
  if (bytes.size() < sizeof number) return false;
  std::memcpy(&number, bytes.data(), sizeof number);
  bytes.remove_prefix(sizeof number);
  return true;
}

bool take_variables(std::string_view& bytes, int depth, std::vector<MatVariable>& variables) {
  std::uint64_t count = 0, name_bytes = 0, kind = 0, is_matrix = 0, height = 0, width = 0, values = 0;
  if (!take_number(bytes, count) || count > bytes.size() || depth > deepest_structure) return false;
  for (std::uint64_t i = 0; i < count; ++i) {
    MatVariable& made = variables.emplace_back();
    if (!take_number(bytes, name_bytes) || name_bytes > bytes.size()) return false;
    made.name = bytes.substr(0, name_bytes);
    bytes.remove_prefix(name_bytes);
    if (!take_number(bytes, kind) || kind > static_cast<std::uint64_t>(MatVariable::Kind::function)) return false;
    if (!take_number(bytes, is_matrix) || is_matrix > 1 || !take_number(bytes, height) || !take_number(bytes, width))
      return false;
    made.kind = static_cast<MatVariable::Kind>(kind);
    made.is_matrix = is_matrix == 1;
    made.height = height;
    made.width = width;
    if (!take_number(bytes, values) || values > bytes.size() / sizeof(double)) return false;
    if (values != 0 && (width == 0 || values % width != 0 || values / width != height)) return false;
    made.values.resize(values);
    if (values != 0) std::memcpy(made.values.data(), bytes.data(), values * sizeof(double));
    bytes.remove_prefix(values * sizeof(double));
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
  constexpr std::size_t besides = std::size_t{1} << 28;  // HDF5's own
  constexpr unsigned most_seconds = 30;
  const std::size_t most_values = most_mat_values(file_bytes);
  const std::string file = path.string();
  matio();  // here, since a child's errors stay with it
  const auto answer = in_child([&] { return to_bytes(read_by_matio(file, most_values)); },
                               {besides + 3 * sizeof(double) * most_values, most_seconds});
  std::vector<MatVariable> variables;
  if (!answer || !from_bytes(*answer, variables))
    throw Error(file, "cannot be read: it is damaged, or far too large for a recording",
                "save it in MATLAB with save('file.mat', 'time', 'sway'), or as CSV");
  return variables;
}

}  // namespace decid::dataset
