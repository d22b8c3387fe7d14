// Reads data sets: see npz.hpp. Writing refuses whatever reading would refuse. Formats: numpy.lib.format (npy.hpp), zip
// by libzip.
#include "dataset/npz/npz.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <new>
#include <numeric>
#include <system_error>

#include "base/error.hpp"
#include "base/files/disk_file.hpp"
#include "base/files/json_object.hpp"
#include "base/parallel.hpp"
#include "base/per_thread.hpp"
#include "base/text.hpp"
#include "dataset/npz/detail/libzip.hpp"
#include "dataset/npz/detail/npz_parts.hpp"
#include "sim/protocol/protocol_object.hpp"

namespace decid::dataset {

namespace {

constexpr const char* regenerate = "make the data set again with decid dataset";
/// Deflate cannot expand data by more than this factor (zlib's technical details), so a larger claim is wrong.
constexpr std::uint64_t deflate_limit = 1032;

constexpr std::uint64_t max_text_bytes = std::uint64_t{1} << 24;  // the limit of a journal's request

struct Discard {
  void operator()(zip_t* archive) const { libzip().discard(archive); }
};
using Archive = std::unique_ptr<zip_t, Discard>;

struct Close {
  void operator()(zip_file_t* file) const { libzip().close_member(file); }
};
using Member = std::unique_ptr<zip_file_t, Close>;

Archive open_archive(const std::string& path, int flags, const std::string& where) {
  int code = 0;
  Archive archive(libzip().open(path.c_str(), flags, &code));
  if (archive) return archive;
  if (code == ZIP_ER_MEMORY) throw std::bad_alloc();
  zip_error_t error;
  libzip().error_init(&error, code);
  const std::string problem = libzip().to_text(&error);
  libzip().error_fini(&error);
  if (code == ZIP_ER_NOENT)
    throw Error(Code::file_missing, where, "cannot be opened: No such file or directory",
                "check the name and the permissions of the file");
  if (std::error_code none; std::filesystem::is_directory(path, none))
    throw Error(Code::file_unreadable, where, "is a folder", "give the name of a file");
  throw Error(Code::file_damaged, where, "cannot be opened as an .npz file: " + problem,
              "give a data set made by decid dataset; a download or copy may be truncated");
}

void require(bool condition, const std::string& where, const std::string& problem) {
  if (!condition) throw Error(Code::file_damaged, where, problem, regenerate);
}

template <class Values>
bool all_finite(const Values& values) {
  return std::all_of(values.begin(), values.end(), [](auto value) { return std::isfinite(value); });
}

void check_sway(std::span<const float> sway, std::size_t trial, const std::string& where) {
  if (!all_finite(sway)) {
    throw Error(Code::file_damaged, where,
                "the sway of trial " + std::to_string(trial) + " has values that are not finite", regenerate);
  }
}

/// Checks everything except the sway. `sway_trials`: the number of trials in the sway.
void check_labels(const Dataset& data, std::size_t sway_trials, const std::string& where) {
  const std::size_t trials = data.parameters.size();
  require(trials > 0, where, "contains no trials");
  require(trials <= std::size_t{std::numeric_limits<int>::max()}, where, "contains more than 2^31 - 1 trials");
  require(data.samples > 0 && sway_trials == trials, where, "sway and parameters disagree about the number of trials");
  require(data.group.size() == trials, where, "group does not have one value per trial");
  require(data.split.size() == trials, where, "split does not have one value per trial");
  require(data.samples == data.protocol.samples(), where,
          "its trials have " + std::to_string(data.samples) + " samples, its protocol '" + data.protocol.name +
              "' makes " + std::to_string(data.protocol.samples()));
  for (std::size_t i = 0; i < trials; ++i) {
    const std::string trial = " of trial " + std::to_string(i);
    require(data.parameters[i].size() == data.protocol.parameters().size(), where,
            "the parameters" + trial + " do not match its body model");
    require(all_finite(data.parameters[i]), where, "the parameters" + trial + " are not finite");
    const std::int32_t parent = data.group[i];
    require(parent >= 0 && static_cast<std::size_t>(parent) < trials &&
                data.group[static_cast<std::size_t>(parent)] == parent,
            where, "the group" + trial + ", " + std::to_string(parent) + ", is not a base trial");
    require(data.split[i] <= 1, where, "the split" + trial + " is " + std::to_string(data.split[i]) + ", not 0 or 1");
  }
}

std::string to_text(const std::vector<std::size_t>& shape) {
  if (shape.empty()) return "a single value";
  return joined(shape, " x ", [](std::size_t extent) { return std::to_string(extent); });
}

/// An archive opened for reading. Its members' claimed sizes are checked against the size of the file.
struct Source {
  explicit Source(const std::filesystem::path& path)
      : where(path.string()),
        archive(open_archive(where, ZIP_RDONLY, where)),
        bytes(std::filesystem::file_size(path)) {}

  std::string where;
  Archive archive;
  std::uint64_t bytes;
  /// Limit for all members still to be read: decid does not compress.
  mutable std::uint64_t inflated_left = std::max(std::uint64_t{1} << 26, 8 * bytes);
};

/// One array of an archive.
class Reader {
 public:
  Reader(const Source& source, const std::string& name) : where_(source.where + ": " + name) {
    zip_t* archive = source.archive.get();
    const std::string member = name + ".npy";
    zip_stat_t stat;
    libzip().stat_init(&stat);
    if (libzip().stat(archive, member.c_str(), 0, &stat) < 0) {
      throw Error(Code::file_unsupported, source.where, "has no array '" + name + "'",
                  "give a data set made by decid dataset");
    }
    if (!(stat.valid & ZIP_STAT_SIZE) || !(stat.valid & ZIP_STAT_COMP_SIZE) || stat.comp_size > source.bytes ||
        stat.size / deflate_limit > stat.comp_size) {
      throw Error(Code::file_damaged, where_, "claims more values than the file can contain", regenerate);
    }
    if (stat.size > source.inflated_left)
      throw Error(Code::file_unsupported, where_, "is compressed too strongly for a data set",
                  "write it with numpy.savez, which does not compress");
    source.inflated_left -= stat.size;
    size_ = stat.size;
    crc32_ = stat.crc;
    stored_ = stat.valid & ZIP_STAT_COMP_METHOD && stat.comp_method == ZIP_CM_STORE;
    member_.reset(libzip().open_member(archive, member.c_str(), 0));
    if (!member_ && libzip().code_of(libzip().error_of(archive)) == ZIP_ER_MEMORY) throw std::bad_alloc();
    if (!member_)
      throw Error(Code::file_damaged, where_, std::string("cannot be read: ") + libzip().error_text(archive),
                  regenerate);
    read_header();
  }

  const NpyHeader& header() const { return header_; }
  bool is_stored() const { return stored_; }
  std::uint32_t crc32() const { return crc32_; }  ///< of the member, including its header

  /// Returns all values of an array of type T: one dimension if `columns` is 1, else two, of any width if it is 0.
  template <class T>
  std::vector<T> values(std::size_t columns) {
    check<T>(columns);
    const std::size_t count = value_count(header_.shape);
    try {
      std::vector<T> result(count);
      read_rest(result.data(), count * sizeof(T));
      return result;
    } catch (const std::bad_alloc&) {
      throw Error(Code::out_of_memory, where_,
                  "needs " + std::to_string(count * sizeof(T) / 1'000'000) + " MB of memory",
                  "use a machine with more memory or a smaller data set");
    }
  }

  /// Throws Error unless the array has values of type T in this shape.
  template <class T>
  void check(std::size_t columns) const {
    const std::size_t dimensions = columns == 1 ? 1 : 2;
    if (header_.type != npy_type<T>()) refuse("of type " + header_.type, std::string("type ") + npy_type<T>());
    if (header_.shape.size() != dimensions || (dimensions == 2 && columns != 0 && header_.shape[1] != columns)) {
      refuse(to_text(header_.shape), columns == 0   ? "trials x samples"
                                     : columns == 1 ? "one value per trial"
                                                    : "trials x " + std::to_string(columns));
    }
    const std::size_t count = value_count(header_.shape);
    if ((size_ - header_.bytes) % sizeof(T) != 0 || (size_ - header_.bytes) / sizeof(T) != count) {
      throw Error(Code::file_damaged, where_,
                  "has a number of values that differs from its shape, " + to_text(header_.shape), regenerate);
    }
  }

  /// Returns the bytes of a single value of type S, without its zero padding.
  std::string bytes() {
    if (!header_.type.starts_with("|S") || !header_.shape.empty()) {
      refuse("of type " + header_.type + ", " + to_text(header_.shape), "a single value of bytes (type |S)");
    }
    if (size_ > max_text_bytes) refuse("larger than 16 MB", "a description");
    std::string content(static_cast<std::size_t>(size_ - header_.bytes), '\0');
    read_rest(content.data(), content.size());
    content.erase(content.find_last_not_of('\0') + 1);
    return content;
  }

 private:
  void read_header() {
    // A header of format 2.0 may exceed 64 KiB, but only arrays of records need that: it counts as cut off.
    std::string front(static_cast<std::size_t>(std::min<std::uint64_t>(size_, 10)), '\0');
    read_bytes(front.data(), front.size());
    if (front.size() == 10 && front.starts_with("\x93NUMPY")) {
      const auto byte = [&](std::size_t index) { return std::size_t{static_cast<unsigned char>(front[index])}; };
      const std::size_t rest = (byte(8) | byte(9) << 8) + (byte(6) == 1 ? 0 : 2);
      std::string more(static_cast<std::size_t>(std::min<std::uint64_t>(size_ - 10, rest)), '\0');
      read_bytes(more.data(), more.size());
      front += more;
    }
    header_ = parse_npy_header(front, where_);
    if (header_.fortran_order) refuse("in Fortran order", "C order: numpy.ascontiguousarray(array)");
  }

  void read_bytes(void* target, std::size_t bytes) {
    auto* position = static_cast<char*>(target);
    while (bytes > 0) {
      const zip_int64_t count = libzip().read(member_.get(), position, bytes);
      if (count <= 0) damaged();
      position += count;
      bytes -= static_cast<std::size_t>(count);
    }
  }

  void read_rest(void* target, std::size_t bytes) {
    read_bytes(target, bytes);
    char beyond;  // reading past the end makes libzip check the checksum
    if (libzip().read(member_.get(), &beyond, 1) != 0) damaged();
  }

  [[noreturn]] void refuse(const std::string& found, const std::string& expected) const {
    throw Error(Code::file_unsupported, where_, "the array is " + found, "give " + expected);
  }

  [[noreturn]] void damaged() const {
    if (libzip().code_of(libzip().error_of_member(member_.get())) == ZIP_ER_MEMORY) throw std::bad_alloc();
    const std::string detail = libzip().member_error_text(member_.get());
    throw Error(Code::file_damaged, where_, "is damaged: " + detail, regenerate);
  }

  std::string where_;
  Member member_;
  NpyHeader header_;
  std::uint64_t size_ = 0;
  std::uint32_t crc32_ = 0;
  bool stored_ = false;
};

void read_description(const std::string& text, const std::string& where, Dataset& data) {
  const Json json = parse_json(text, where);
  JsonObject object(json, where);
  int format = 0;
  object.read("format", format);
  if (format != npz_format_version) {
    throw Error(Code::file_unsupported, where,
                "is of data set format " + std::to_string(format) + ", and this program reads format 1",
                "use the decid that wrote it, or make it again");
  }
  object.require("seed");
  object.read("seed", data.seed);
  data.protocol = sim::protocol_from_object(object.require("protocol"), where + ": protocol");
  std::vector<std::string> names;
  object.require("parameters");
  object.read("parameters", names);
  const std::vector<std::string> expected = data.protocol.parameters().names();
  if (names != expected)
    throw Error(Code::file_unsupported, where, "lists parameters other than " + joined(expected, ", "), regenerate);
  object.finish();
}

/// Reads everything except the values of the sway.
Dataset read_labels(const Source& source, const Reader& sway) {
  Dataset data;
  read_description(Reader(source, "decid.json").bytes(), source.where + ": decid.json", data);
  sway.check<float>(0);
  const std::vector<std::size_t>& shape = sway.header().shape;
  if (shape[1] > std::size_t{std::numeric_limits<int>::max()}) {
    throw Error(Code::file_too_large, source.where, "its trials have more than 2^31 - 1 samples", regenerate);
  }
  data.samples = static_cast<int>(shape[1]);
  const std::size_t count = data.protocol.parameters().size();
  const std::vector<double> parameters = Reader(source, "parameters").values<double>(count);
  data.parameters.assign(parameters.size() / count, sim::Parameters(count));
  for (std::size_t i = 0; i < parameters.size(); ++i) data.parameters[i / count][i % count] = parameters[i];
  data.group = Reader(source, "group").values<std::int32_t>(1);
  data.split = Reader(source, "split").values<std::uint8_t>(1);
  check_labels(data, shape[0], source.where);
  return data;
}

Dataset read_all(const Source& source, Reader& sway) {
  Dataset data = read_labels(source, sway);
  data.sway = sway.values<float>(0);
  for (int i = 0; i < data.trials(); ++i) check_sway(data.trial(i), static_cast<std::size_t>(i), source.where);
  return data;
}

/// Returns the offset of the first member's content, if it is `name` and stored; else 0.
std::uint64_t first_member(const DiskFile& file, const std::string& name) {
  std::array<unsigned char, 30> header{};  // zip.cpp: zip_local_header
  std::string found(name.size(), '\0');
  file.read(0, std::as_writable_bytes(std::span(header)));
  file.read(header.size(), std::as_writable_bytes(std::span(found)));
  const auto u16 = [&](std::size_t at) { return std::uint64_t{header[at]} | std::uint64_t{header[at + 1]} << 8; };
  const bool is_header = u16(0) == 0x4b50 && u16(2) == 0x0403 && u16(8) == 0 && u16(26) == name.size();
  return is_header && found == name ? header.size() + name.size() + u16(28) : 0;
}

}  // namespace

void check_dataset(const Dataset& data, const std::string& where) {
  const auto samples = static_cast<std::size_t>(std::max(data.samples, 1));
  check_labels(data, data.sway.size() % samples == 0 ? data.sway.size() / samples : 0, where);
  for (int i = 0; i < data.trials(); ++i) check_sway(data.trial(i), static_cast<std::size_t>(i), where);
}

Dataset read_npz(const std::filesystem::path& path) {
  const Source source(path);
  Reader sway(source, "sway");
  return read_all(source, sway);
}

struct StoredDataset::File {
  DiskFile file;
  std::uint64_t start;  // of the first trial
};

StoredDataset::StoredDataset(Dataset data) : data_(std::move(data)) {}

StoredDataset::StoredDataset(const std::filesystem::path& path) {
  const Source source(path);
  Reader sway(source, "sway");
  DiskFile file(path, DiskFile::Access::read);
  const std::uint64_t member = first_member(file, "sway.npy");
  if (member == 0 || !sway.is_stored()) {
    data_ = read_all(source, sway);
    return;
  }
  data_ = read_labels(source, sway);
  file_ = std::make_shared<const File>(File{std::move(file), member + sway.header().bytes});
  std::vector<std::byte> header(sway.header().bytes);
  file_->file.read(member, header);

  std::vector<std::uint32_t> parts(data_.parameters.size());
  take(0, trials(), [&](std::size_t i, std::span<const float> values) {
    check_sway(values, i, source.where);
    parts[i] = crc32(std::as_bytes(values));
  });
  std::uint32_t sum = crc32(header);
  const std::size_t trial_bytes = static_cast<std::size_t>(data_.samples) * sizeof(float);
  for (const std::uint32_t part : parts) sum = crc32_joined(sum, part, trial_bytes);
  if (sum != sway.crc32())
    throw Error(Code::file_damaged, source.where + ": sway", "is damaged: its CRC does not match", regenerate);
}

void StoredDataset::read(int index, std::span<float> sway_rad) const {
  if (index < 0 || index >= trials()) {
    throw Error(Code::setting_out_of_range, "data set", "has no trial " + std::to_string(index),
                "request trials 0 to " + std::to_string(trials() - 1));
  }
  if (sway_rad.size() != static_cast<std::size_t>(data_.samples)) {
    throw Error(Code::size_mismatch, "data set",
                "the output has space for " + std::to_string(sway_rad.size()) + " samples",
                "give space for " + std::to_string(data_.samples));
  }
  if (!file_) {
    std::ranges::copy(data_.trial(index), sway_rad.begin());
    return;
  }
  const auto bytes = std::as_writable_bytes(sway_rad);
  if (file_->file.read(file_->start + static_cast<std::uint64_t>(index) * bytes.size(), bytes) != bytes.size()) {
    throw Error(Code::file_damaged, file_->file.path().string(), "became shorter while in use", regenerate);
  }
}

void StoredDataset::take(std::span<const int> indices, const Take& take) const {
  parallel_for(static_cast<int>(indices.size()), [&](int i) {
    struct Scratch {
      std::vector<float> sway;
    };
    std::vector<float>& sway = per_thread<Scratch>().sway;
    sway.resize(static_cast<std::size_t>(data_.samples));
    const auto place = static_cast<std::size_t>(i);
    read(indices[place], sway);
    take(place, sway);
  });
}

void StoredDataset::take(int first, int count, const Take& take) const {
  std::vector<int> indices(static_cast<std::size_t>(count));
  std::iota(indices.begin(), indices.end(), first);
  this->take(indices, take);
}

}  // namespace decid::dataset
