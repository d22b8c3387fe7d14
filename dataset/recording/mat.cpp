// MAT-files: see mat.hpp. matio opens all versions; what it returns is checked before it is used, since a file's header
// may claim anything.
#include "dataset/recording/mat.hpp"

#include <matio.h>
#include <zlib.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <map>

#include "base/error.hpp"
#include "dataset/recording/columns.hpp"

namespace decid::dataset {

namespace {

constexpr std::size_t most_values = 100'000'000;
constexpr int deepest = 4;

struct Close {
  void operator()(mat_t* file) const { Mat_Close(file); }
};
struct Free {
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};

template <class T>
void convert(const void* data, std::size_t count, std::vector<double>& values) {
  const T* from = static_cast<const T*>(data);
  values.assign(from, from + count);
}

/// False if the variable is not a real array of numbers.
bool numbers_of(const matvar_t& variable, std::size_t count, std::vector<double>& values) {
  if (variable.isComplex != 0 || variable.data == nullptr || variable.data_size <= 0) return false;
  if (variable.nbytes / static_cast<std::size_t>(variable.data_size) < count) return false;
  switch (variable.class_type) {
    case MAT_C_DOUBLE:
      convert<double>(variable.data, count, values);
      return true;
    case MAT_C_SINGLE:
      convert<float>(variable.data, count, values);
      return true;
    case MAT_C_INT8:
      convert<std::int8_t>(variable.data, count, values);
      return true;
    case MAT_C_UINT8:
      convert<std::uint8_t>(variable.data, count, values);
      return true;
    case MAT_C_INT16:
      convert<std::int16_t>(variable.data, count, values);
      return true;
    case MAT_C_UINT16:
      convert<std::uint16_t>(variable.data, count, values);
      return true;
    case MAT_C_INT32:
      convert<std::int32_t>(variable.data, count, values);
      return true;
    case MAT_C_UINT32:
      convert<std::uint32_t>(variable.data, count, values);
      return true;
    case MAT_C_INT64:
      convert<std::int64_t>(variable.data, count, values);
      return true;
    case MAT_C_UINT64:
      convert<std::uint64_t>(variable.data, count, values);
      return true;
    default:
      return false;
  }
}

const char* kind_of(const matvar_t& variable) {
  switch (variable.class_type) {
    case MAT_C_CELL:
      return "cell";
    case MAT_C_STRUCT:
      return "struct";
    case MAT_C_CHAR:
      return "text";
    case MAT_C_SPARSE:
      return "sparse";
    case MAT_C_OBJECT:
    case MAT_C_OPAQUE:
      return "object";
    case MAT_C_FUNCTION:
      return "function";
    default:
      return variable.isComplex != 0 ? "complex" : "numbers";
  }
}

bool is_rate(const std::string& name) {
  const std::string plain = name_without_unit(name);
  return one_of(plain, {"fs", "rate", "rate_hz", "fs_hz", "sample_rate", "samplerate", "sample_rate_hz", "samplingrate",
                        "sampling_rate", "sampling_rate_hz", "sf", "freq", "frequency", "sample_frequency"});
}

/// What a file holds, before its columns are named.
struct Columns {
  std::vector<std::string> leaf, path;
  std::vector<std::vector<double>> values;
  bool named = false;
  std::optional<double> rate_hz;
  std::string held;  ///< all variables, for an Error
};

void collect(const matvar_t& variable, const std::string& outer, int depth, Columns& columns) {
  if (variable.rank != 2 || variable.dims == nullptr) return;
  const std::string name = variable.name != nullptr ? variable.name : "";
  const std::string path = outer.empty() ? name : outer + "." + name;
  const std::size_t height = variable.dims[0], width = variable.dims[1];
  if (columns.held.size() < 200) {
    columns.held += (columns.held.empty() ? "" : ", ") + path + " (" + std::to_string(height) + " x " +
                    std::to_string(width) + " " + kind_of(variable) + ")";
  }
  if (variable.class_type == MAT_C_STRUCT) {
    if (height != 1 || width != 1 || depth >= deepest || variable.data == nullptr) return;
    const auto* const* fields = static_cast<matvar_t* const*>(variable.data);
    const unsigned count = Mat_VarGetNumberOfFields(const_cast<matvar_t*>(&variable));
    for (unsigned i = 0; i < count && i * sizeof(void*) < variable.nbytes; ++i) {
      if (fields[i] != nullptr) collect(*fields[i], path, depth + 1, columns);
    }
    return;
  }
  std::vector<double> all;
  if (height == 0 || width == 0 || height > most_values / width) return;
  if (!numbers_of(variable, height * width, all)) return;
  if (all.size() == 1) {
    if (is_rate(name) && std::isfinite(all[0]) && all[0] > 0.0) columns.rate_hz = all[0];
    return;
  }
  if (height == 1 || width == 1) {
    columns.leaf.push_back(name);
    columns.path.push_back(path);
    columns.values.push_back(std::move(all));
    columns.named = true;
    return;
  }
  const bool wide = width > height;
  const std::size_t signals = wide ? height : width, samples = wide ? width : height;
  for (std::size_t s = 0; s < signals && columns.values.size() <= most_columns; ++s) {
    const std::string index = wide ? "(" + std::to_string(s + 1) + ",:)" : "(:," + std::to_string(s + 1) + ")";
    columns.leaf.push_back(name + index);
    columns.path.push_back(path + index);
    columns.values.emplace_back(samples);
    for (std::size_t k = 0; k < samples; ++k) columns.values.back()[k] = all[wide ? k * height + s : s * height + k];
  }
}

constexpr std::size_t header_bytes = 128, tag_bytes = 8;
constexpr std::uint32_t compressed = 15;
constexpr unsigned long long inflated_limit = 1ULL << 32;

std::uint32_t word(std::string_view bytes, std::size_t at, bool little_endian) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto byte = static_cast<unsigned char>(bytes[at + (little_endian ? 3 - i : i)]);
    value = value << 8 | byte;
  }
  return value;
}

/// How long a zlib stream is when inflated; nothing if it is damaged, or longer than `limit`.
std::optional<unsigned long long> inflated_size(std::string_view bytes, unsigned long long limit) {
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) return {};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  std::vector<Bytef> scratch(std::size_t{1} << 16);
  int status = Z_OK;
  unsigned long long size = 0;
  while (status == Z_OK && size <= limit) {
    stream.next_out = scratch.data();
    stream.avail_out = static_cast<uInt>(scratch.size());
    status = inflate(&stream, Z_NO_FLUSH);
    size += scratch.size() - stream.avail_out;
  }
  inflateEnd(&stream);
  if (status != Z_STREAM_END || size > limit) return {};
  return size;
}

}  // namespace

void check_mat(std::string_view bytes, const std::string& where) {
  if (!bytes.starts_with("MATLAB 5.0") || bytes.size() < header_bytes) return;
  const bool little_endian = bytes[header_bytes - 2] == 'I';
  unsigned long long left = inflated_limit;
  for (std::size_t at = header_bytes; at < bytes.size();) {
    const bool has_tag = bytes.size() - at >= tag_bytes;
    const std::size_t size = has_tag ? word(bytes, at + 4, little_endian) : 0;
    if (!has_tag || size > bytes.size() - at - tag_bytes) {
      throw Error(where, "is cut short or damaged at byte " + std::to_string(at), "copy or save it again");
    }
    if (word(bytes, at, little_endian) == compressed) {
      const auto inflated = inflated_size(bytes.substr(at + tag_bytes, size), left);
      if (!inflated) {
        throw Error(where, "is damaged, or far too large, in what is compressed from byte " + std::to_string(at),
                    "copy or save it again, the trial to be identified alone");
      }
      left -= *inflated;
    }
    at += tag_bytes + size;
  }
}

MatTable::MatTable(const std::filesystem::path& path) : where_(path.string()) {
  const char* remedy = "save it in MATLAB with save('file.mat', 'time', 'sway'), or as CSV";
  const std::unique_ptr<mat_t, Close> file(Mat_Open(where_.c_str(), MAT_ACC_RDONLY));
  if (!file) throw Error(where_, "is not a MAT-file that can be read, or is damaged", remedy);
  const bool is_hdf5 = Mat_GetVersion(file.get()) == MAT_FT_MAT73;
  Columns columns;
  // Sizes are checked before the values are read: a header may claim anything.
  while (const std::unique_ptr<matvar_t, Free> variable{Mat_VarReadNextInfo(file.get())}) {
    std::size_t count = 1;
    for (int d = 0; d < variable->rank; ++d) {
      const std::size_t size = variable->dims[d];
      count = size != 0 && count > most_values / size ? most_values + 1 : count * size;
    }
    if (count > most_values) {
      throw Error(where_, std::string(variable->name != nullptr ? variable->name : "") + " claims too many values",
                  "save the trial to be identified alone");
    }
    // h5py pads the name of the class with nulls where MATLAB ends it with one, or leaves it out; matio then knows no
    // class. HDF5 itself converts whatever numbers there are.
    if (variable->class_type == MAT_C_EMPTY && is_hdf5 && count > 0) {
      variable->class_type = MAT_C_DOUBLE;
      variable->data_type = MAT_T_DOUBLE;
    }
    const bool may_hold_numbers = variable->class_type == MAT_C_STRUCT ||
                                  (variable->class_type >= MAT_C_DOUBLE && variable->class_type <= MAT_C_UINT64);
    if (may_hold_numbers && Mat_VarReadDataAll(file.get(), variable.get()) != 0) {
      throw Error(where_, std::string(variable->name != nullptr ? variable->name : "") + " cannot be read: damaged",
                  remedy);
    }
    collect(*variable, "", 0, columns);
  }
  if (columns.values.empty()) {
    throw Error(where_,
                columns.held.empty() ? "holds no variables" : "holds no vector or matrix of numbers: " + columns.held,
                remedy);
  }
  if (columns.values.size() > most_columns) {
    throw Error(where_, "has " + std::to_string(columns.values.size()) + " columns", "at most 1000 can be read");
  }
  std::map<std::string, int> uses;
  for (const std::string& leaf : columns.leaf) ++uses[leaf];
  for (std::size_t i = 0; i < columns.leaf.size(); ++i) {
    if (columns.values[i].size() > most_rows) {
      throw Error(where_, columns.path[i] + " has more than 10 million values", "cut it to the trial to be identified");
    }
    names_.push_back(uses[columns.leaf[i]] > 1 ? columns.path[i] : columns.leaf[i]);
  }
  values_ = std::move(columns.values);
  named_ = columns.named;
  rate_hz_ = columns.rate_hz;
}

std::vector<double> MatTable::numbers(int column, Missing missing) const {
  const std::vector<double>& values = values_[static_cast<std::size_t>(column)];
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (std::isfinite(values[k]) || (missing == Missing::kept && std::isnan(values[k]))) continue;
    throw Error(where_,
                place_of(k) + ", " + names_[static_cast<std::size_t>(column)] + ": " +
                    (std::isnan(values[k]) ? "NaN" : "an infinite value") + " is not a finite number",
                remedy_for(std::isnan(values[k]) ? missing : Missing::refused));
  }
  return values;
}

}  // namespace decid::dataset
