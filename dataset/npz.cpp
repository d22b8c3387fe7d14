// Data sets as .npz: NumPy arrays in a zip archive. Whatever a reader would refuse is refused when writing too.
// Formats: numpy.lib.format (npy.hpp), zip by libzip.
#include "dataset/npz.hpp"

#include <zip.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <concepts>
#include <limits>
#include <memory>
#include <new>

#include "base/error.hpp"
#include "base/file.hpp"
#include "dataset/json_object.hpp"
#include "dataset/npy.hpp"
#include "dataset/protocol_json.hpp"

namespace decid::dataset {

static_assert(std::endian::native == std::endian::little, "arrays are written as they lie in memory");

namespace {

constexpr const char* regenerate = "make the data set again with decid dataset";
constexpr int format_version = 1;
/// Deflate cannot expand data by more than this factor (zlib's technical details), so a larger claim is a lie.
constexpr std::uint64_t deflate_limit = 1032;

struct Discard {
  void operator()(zip_t* archive) const { zip_discard(archive); }
};
using Archive = std::unique_ptr<zip_t, Discard>;

struct Close {
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};
using Member = std::unique_ptr<zip_file_t, Close>;

Archive open_archive(const std::string& path, int flags, const std::string& where) {
  int code = 0;
  Archive archive(zip_open(path.c_str(), flags, &code));
  if (archive) return archive;
  zip_error_t error;
  zip_error_init_with_code(&error, code);
  const std::string problem = zip_error_strerror(&error);
  zip_error_fini(&error);
  throw Error(where, "cannot be opened as an .npz file: " + problem,
              "name a data set made by decid dataset; a download or copy may have been cut short");
}

/// What must hold of a data set on either side of the disk.
void check(const Dataset& data, const std::string& where) {
  const auto require = [&](bool condition, const std::string& problem) {
    if (!condition) throw Error(where, problem, regenerate);
  };
  const std::size_t trials = data.parameters.size(), samples = static_cast<std::size_t>(std::max(data.samples, 0));
  require(trials > 0, "holds no trials");
  require(trials <= std::size_t{std::numeric_limits<int>::max()}, "holds more than 2^31 - 1 trials");
  require(samples > 0 && data.sway.size() / samples == trials && data.sway.size() % samples == 0,
          "sway and parameters disagree about the number of trials");
  require(data.group.size() == trials, "group does not have one value a trial");
  require(data.split.size() == trials, "split does not have one value a trial");
  require(data.samples == data.protocol.samples(), "its trials have " + std::to_string(data.samples) +
                                                       " samples, its protocol '" + data.protocol.name + "' makes " +
                                                       std::to_string(data.protocol.samples()));
  for (std::size_t i = 0; i < trials; ++i) {
    const std::string trial = " of trial " + std::to_string(i);
    const auto sway = data.trial(static_cast<int>(i));
    const auto finite = [](auto value) { return std::isfinite(value); };
    require(std::all_of(sway.begin(), sway.end(), finite), "the sway" + trial + " has values that are not finite");
    require(std::all_of(data.parameters[i].begin(), data.parameters[i].end(), finite),
            "the parameters" + trial + " are not finite");
    const std::int32_t parent = data.group[i];
    require(parent >= 0 && static_cast<std::size_t>(parent) < trials &&
                data.group[static_cast<std::size_t>(parent)] == parent,
            "the group" + trial + ", " + std::to_string(parent) + ", is not a base trial's");
    require(data.split[i] <= 1, "the split" + trial + " is " + std::to_string(data.split[i]) + ", not 0 or 1");
  }
}

std::string describe(const Dataset& data) {
  std::vector<std::string> names;
  for (const sim::ParameterInfo& info : sim::parameter_info) names.emplace_back(info.name);
  return print_json({{"format", format_version},
                     {"seed", data.seed},
                     {"protocol", parse_json(to_json(data.protocol), "protocol")},
                     {"parameters", names}});
}

/// Adds members to an archive; the values must stay where they are until the archive is closed.
class Writer {
 public:
  explicit Writer(const std::string& path, const std::string& where)
      : where_(where), archive_(open_archive(path, ZIP_CREATE | ZIP_TRUNCATE, where)) {}

  void add(const char* name, const std::string& type, const std::vector<std::size_t>& shape, const void* values,
           std::size_t bytes) {
    headers_.push_back(std::make_unique<std::string>(npy_header(type, shape)));
    const std::string& header = *headers_.back();
    // libzip's fragments are not const, but it only reads them.
    auto* front = reinterpret_cast<zip_uint8_t*>(const_cast<char*>(header.data()));
    auto* rest = static_cast<zip_uint8_t*>(const_cast<void*>(values));
    const zip_buffer_fragment_t fragments[]{{front, header.size()}, {rest, bytes}};
    zip_source_t* source = zip_source_buffer_fragment(archive_.get(), fragments, 2, 0);
    if (!source) fail();
    const zip_int64_t index = zip_file_add(archive_.get(), (std::string(name) + ".npy").c_str(), source, 0);
    if (index < 0) {
      zip_source_free(source);
      fail();
    }
    const auto member = static_cast<zip_uint64_t>(index);
    // 1 January 1980, the format's earliest. A time in seconds would be written in the local time zone.
    constexpr zip_uint16_t midnight = 0, first_day = (1 << 5) | 1;
    if (zip_set_file_compression(archive_.get(), member, ZIP_CM_STORE, 0) < 0 ||
        zip_file_set_dostime(archive_.get(), member, midnight, first_day, 0) < 0) {
      fail();
    }
  }

  /// Writes everything. libzip works in a temporary file of its own beside `path` and removes it on failure.
  void close() {
    if (zip_close(archive_.get()) < 0) fail();
    static_cast<void>(archive_.release());  // zip_close freed it
  }

 private:
  [[noreturn]] void fail() const {
    throw Error(where_, std::string("cannot be written: ") + zip_strerror(archive_.get()),
                "check the free space and the permissions there");
  }

  std::string where_;
  std::vector<std::unique_ptr<std::string>> headers_;  // on the heap each: libzip keeps their addresses
  Archive archive_;
};

/// The NumPy type of values of type T.
template <class T>
constexpr const char* npy_type() {
  if constexpr (std::same_as<T, float>) return "<f4";
  if constexpr (std::same_as<T, double>) return "<f8";
  if constexpr (std::same_as<T, std::int32_t>) return "<i4";
  if constexpr (std::same_as<T, std::uint8_t>) return "|u1";
}

std::string text_of(const std::vector<std::size_t>& shape) {
  std::string text;
  for (const std::size_t extent : shape) text += (text.empty() ? "" : " x ") + std::to_string(extent);
  return text.empty() ? "a single value" : text;
}

/// An archive opened for reading. Its members' claimed sizes are held against the size of the file.
struct Source {
  explicit Source(const std::filesystem::path& path)
      : where(path.string()),
        archive(open_archive(where, ZIP_RDONLY, where)),
        bytes(std::filesystem::file_size(path)) {}

  std::string where;
  Archive archive;
  std::uint64_t bytes;
};

/// One array of an archive.
class Reader {
 public:
  Reader(const Source& source, const std::string& name) : where_(source.where + ": " + name) {
    zip_t* archive = source.archive.get();
    const std::string member = name + ".npy";
    zip_stat_t stat;
    zip_stat_init(&stat);
    if (zip_stat(archive, member.c_str(), 0, &stat) < 0) {
      throw Error(source.where, "has no array '" + name + "'", "name a data set made by decid dataset");
    }
    if (!(stat.valid & ZIP_STAT_SIZE) || !(stat.valid & ZIP_STAT_COMP_SIZE) || stat.comp_size > source.bytes ||
        stat.size / deflate_limit > stat.comp_size) {
      throw Error(where_, "claims more values than the file can hold", regenerate);
    }
    size_ = stat.size;
    member_.reset(zip_fopen(archive, member.c_str(), 0));
    if (!member_) throw Error(where_, std::string("cannot be read: ") + zip_strerror(archive), regenerate);
    read_header();
  }

  const NpyHeader& header() const { return header_; }

  /// All values of an array of type T: one dimension if `columns` is 1, else two, of any width if it is 0.
  template <class T>
  std::vector<T> values(std::size_t columns) {
    const std::size_t dimensions = columns == 1 ? 1 : 2;
    if (header_.type != npy_type<T>()) refuse("of type " + header_.type, std::string("type ") + npy_type<T>());
    if (header_.shape.size() != dimensions || (dimensions == 2 && columns != 0 && header_.shape[1] != columns)) {
      refuse(text_of(header_.shape), columns == 0   ? "trials x samples"
                                     : columns == 1 ? "one value a trial"
                                                    : "trials x " + std::to_string(columns));
    }
    const std::size_t count = value_count(header_.shape);
    if ((size_ - header_.bytes) % sizeof(T) != 0 || (size_ - header_.bytes) / sizeof(T) != count) {
      throw Error(where_, "does not hold as many values as its shape says, " + text_of(header_.shape), regenerate);
    }
    try {
      std::vector<T> result(count);
      read_rest(result.data(), count * sizeof(T));
      return result;
    } catch (const std::bad_alloc&) {
      throw Error(where_, "needs " + std::to_string(count * sizeof(T) / 1'000'000) + " MB of memory",
                  "use a machine with more memory or a smaller data set");
    }
  }

  /// The bytes of a single value of type S, without the zeros that pad it.
  std::string bytes() {
    if (!header_.type.starts_with("|S") || !header_.shape.empty()) {
      refuse("of type " + header_.type + ", " + text_of(header_.shape), "a single value of bytes (type |S)");
    }
    std::string content(size_ - header_.bytes, '\0');
    read_rest(content.data(), content.size());
    content.erase(content.find_last_not_of('\0') + 1);
    return content;
  }

 private:
  void read_header() {
    // Format 2.0 can say more than 64 KiB, but only arrays of records need that, and those are refused as cut off.
    std::string front(std::min<std::uint64_t>(size_, 10), '\0');
    read_bytes(front.data(), front.size());
    if (front.size() == 10 && front.starts_with("\x93NUMPY")) {
      const auto byte = [&](std::size_t index) { return std::size_t{static_cast<unsigned char>(front[index])}; };
      const std::size_t rest = (byte(8) | byte(9) << 8) + (byte(6) == 1 ? 0 : 2);
      std::string more(std::min<std::uint64_t>(size_ - 10, rest), '\0');
      read_bytes(more.data(), more.size());
      front += more;
    }
    header_ = parse_npy_header(front, where_);
    if (header_.fortran_order) refuse("in Fortran order", "C order: numpy.ascontiguousarray(array)");
  }

  void read_bytes(void* target, std::size_t bytes) {
    auto* position = static_cast<char*>(target);
    while (bytes > 0) {
      const zip_int64_t count = zip_fread(member_.get(), position, bytes);
      if (count <= 0) damaged();
      position += count;
      bytes -= static_cast<std::size_t>(count);
    }
  }

  void read_rest(void* target, std::size_t bytes) {
    read_bytes(target, bytes);
    char beyond;  // reading up to the end makes libzip compare the checksum
    if (zip_fread(member_.get(), &beyond, 1) != 0) damaged();
  }

  [[noreturn]] void refuse(const std::string& found, const std::string& expected) const {
    throw Error(where_, "the array is " + found, "it must be " + expected);
  }

  [[noreturn]] void damaged() const {
    const std::string detail = zip_file_strerror(member_.get());
    throw Error(where_, "is damaged: " + detail, regenerate);
  }

  std::string where_;
  Member member_;
  NpyHeader header_;
  std::uint64_t size_ = 0;
};

void read_description(const std::string& text, const std::string& where, Dataset& data) {
  const Json json = parse_json(text, where);
  JsonObject object(json, where);
  int format = 0;
  object.read("format", format);
  if (format != format_version) {
    throw Error(where, "is of data set format " + std::to_string(format) + ", this program reads format 1",
                "use the decid that wrote it, or make it again");
  }
  object.require("seed");
  object.read("seed", data.seed);
  data.protocol = protocol_from_json(print_json(object.require("protocol")), where + ": protocol");
  std::vector<std::string> names;
  object.require("parameters");
  object.read("parameters", names);
  const auto same = [](const std::string& name, const sim::ParameterInfo& info) { return name == info.name; };
  if (!std::equal(names.begin(), names.end(), sim::parameter_info.begin(), sim::parameter_info.end(), same)) {
    throw Error(where, "lists other parameters than Kp, Kd, Kp_pass, Kd_pass, Nv, theta, delay", regenerate);
  }
  object.finish();
}

}  // namespace

void write_npz(const std::filesystem::path& path, const Dataset& data) {
  const std::string where = path.string();
  check(data, where);
  const std::size_t trials = data.parameters.size(), samples = static_cast<std::size_t>(data.samples);
  const std::string description = describe(data);
  PendingFile file(path);
  // libzip renames a file of its own to the path it is given, which must never happen to a device.
  if (!std::filesystem::is_regular_file(file.path())) {
    throw Error(where, "is not a regular file, and a zip archive cannot be streamed", "name a file on a disk");
  }
  Writer writer(file.path().string(), where);
  writer.add("sway", npy_type<float>(), {trials, samples}, data.sway.data(), data.sway.size() * sizeof(float));
  writer.add("parameters", npy_type<double>(), {trials, sim::parameter_count}, data.parameters.data(),
             trials * sizeof(sim::Parameters));
  writer.add("group", npy_type<std::int32_t>(), {trials}, data.group.data(), trials * sizeof(std::int32_t));
  writer.add("split", npy_type<std::uint8_t>(), {trials}, data.split.data(), trials);
  writer.add("decid.json", "|S" + std::to_string(description.size()), {}, description.data(), description.size());
  writer.close();
  file.commit();
}

Dataset read_npz(const std::filesystem::path& path) {
  const Source source(path);
  Dataset data;
  read_description(Reader(source, "decid.json").bytes(), source.where + ": decid.json", data);
  Reader sway(source, "sway");
  data.sway = sway.values<float>(0);
  if (sway.header().shape[1] > std::size_t{std::numeric_limits<int>::max()}) {
    throw Error(source.where, "its trials have more than 2^31 - 1 samples", regenerate);
  }
  data.samples = static_cast<int>(sway.header().shape[1]);
  const std::vector<double> parameters = Reader(source, "parameters").values<double>(sim::parameter_count);
  data.parameters.resize(parameters.size() / sim::parameter_count);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    data.parameters[i / sim::parameter_count][i % sim::parameter_count] = parameters[i];
  }
  data.group = Reader(source, "group").values<std::int32_t>(1);
  data.split = Reader(source, "split").values<std::uint8_t>(1);
  check(data, source.where);
  return data;
}

}  // namespace decid::dataset
