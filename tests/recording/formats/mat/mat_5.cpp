// MAT-files of versions 4 and 5, byte by byte: numbers of every type and in either byte order, and what a file may
// claim.
#include "recording/formats/detail/mat/mat_5.hpp"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>

#include "recording/formats/detail/mat/mat.hpp"
#include "recording/table/table.hpp"
#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;
using Kind = MatVariable::Kind;

namespace {

constexpr bool here_first = std::endian::native == std::endian::little;

/// Numbers one behind the other, as a machine of either byte order has them in memory.
template <class T>
std::string bytes_of(std::initializer_list<T> numbers, bool little = here_first) {
  std::string bytes;
  for (const T number : numbers) {
    char raw[sizeof(T)];
    std::memcpy(raw, &number, sizeof(T));
    if (little != here_first) std::reverse(raw, raw + sizeof(T));
    bytes.append(raw, sizeof(T));
  }
  return bytes;
}

/// A variable of version 4 with two rows and one column.
template <class T>
std::string variable_4(std::uint32_t type, std::initializer_list<T> numbers, bool little = true,
                       std::uint32_t imaginary = 0) {
  return bytes_of<std::uint32_t>({type, 2, 1, imaginary, 2}, little) + std::string("x\0", 2) +
         bytes_of<T>(numbers, little);
}

/// The numbers of the only variable.
std::vector<double> only(const std::vector<MatVariable>& variables) {
  REQUIRE(variables.size() == 1);
  CHECK(variables[0].name == "x");
  CHECK(variables[0].height == 2);
  CHECK(variables[0].width == 1);
  return variables[0].values;
}

/// The parts of a file of version 5, in either byte order: an element with its tag and padding, small ones within the
/// tag.
struct Mat5 {
  bool little = true;

  std::string tag(std::uint32_t type, std::size_t size) const {
    return bytes_of<std::uint32_t>({type, static_cast<std::uint32_t>(size)}, little);
  }
  std::string element(std::uint32_t type, const std::string& data) const {
    return tag(type, data.size()) + data + std::string((8 - data.size() % 8) % 8, '\0');
  }
  std::string small(std::uint32_t type, std::string data) const {
    const auto size = static_cast<std::uint32_t>(data.size());
    data.resize(4);
    return bytes_of<std::uint32_t>({size << 16 | type}, little) + data;
  }
  std::string size(std::int32_t height, std::int32_t width) const {
    return element(5, bytes_of<std::int32_t>({height, width}, little));
  }
  /// Class, size and name of a matrix; its values, or its fields, come behind.
  std::string head(std::uint32_t kind, std::int32_t height, std::int32_t width, const std::string& name = "x") const {
    return element(6, bytes_of<std::uint32_t>({kind, 0}, little)) + size(height, width) + element(1, name);
  }
  std::string file(const std::string& elements) const {
    return std::string(124, ' ') + std::string(little ? "\x00\x01IM" : "\x01\x00MI", 4) + elements;
  }
  std::string matrix(const std::string& data) const { return element(14, data); }
};

constexpr std::uint32_t uint32_class = 13, double_class = 6, struct_class = 2;

auto reading_5(const std::string& elements) {
  return [file = Mat5{}.file(elements)] { read_mat_5(file, "trial.mat"); };
}

std::string deflated(const std::string& bytes) {
  std::string out(compressBound(bytes.size()), '\0');
  uLongf size = out.size();
  REQUIRE(compress(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                   bytes.size()) == Z_OK);
  out.resize(size);
  return Mat5{}.tag(15, out.size()) + out;
}

}  // namespace

TEST_CASE("version 4: numbers of every type, in either byte order") {
  const std::vector<double> expected{3.0, 200.0};
  for (const bool little : {true, false}) {
    const std::uint32_t order = little ? 0 : 1000;
    CHECK(only(read_mat_4(variable_4<double>(order, {3, 200}, little), "x")) == expected);
    CHECK(only(read_mat_4(variable_4<float>(order + 10, {3, 200}, little), "x")) == expected);
    CHECK(only(read_mat_4(variable_4<std::int32_t>(order + 20, {3, 200}, little), "x")) == expected);
    CHECK(only(read_mat_4(variable_4<std::int16_t>(order + 30, {3, 200}, little), "x")) == expected);
    CHECK(only(read_mat_4(variable_4<std::uint16_t>(order + 40, {3, 200}, little), "x")) == expected);
    CHECK(only(read_mat_4(variable_4<std::uint8_t>(order + 50, {3, 200}, little), "x")) == expected);
    CHECK(mat_version(variable_4<std::uint8_t>(order + 50, {3, 200}, little)) == MatVersion::v4);
  }
  CHECK(only(read_mat_4(variable_4<std::int16_t>(30, {-3, -200}), "x")) == std::vector{-3.0, -200.0});
}

TEST_CASE("version 4: variables without numbers have a kind and no values, and later variables are read") {
  const std::string file = variable_4<std::uint8_t>(51, {'h', 'i'}) + variable_4<double>(2, {1, 2}) +
                           variable_4<double>(0, {1, 2, 3, 4}, true, 1) + variable_4<double>(0, {7, 8});
  const std::vector<MatVariable> variables = read_mat_4(file, "x");
  REQUIRE(variables.size() == 4);
  const Kind kinds[]{Kind::text, Kind::sparse, Kind::complex, Kind::numbers};
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(variables[i].kind == kinds[i]);
    CHECK(variables[i].values.empty() == (i < 3));
  }
  CHECK(variables[3].values == std::vector{7.0, 8.0});
}

TEST_CASE("version 4: a type that is none, and claims that are too large, are refused") {
  for (const std::uint32_t type : {2000u, 100u, 60u, 3u}) {
    CHECK(mat_version(variable_4<double>(type, {1, 2})) == MatVersion::none);
    check_error(
        [&] {
          read_mat_4(variable_4<double>(0, {1, 2}) + variable_4<double>(type, {1, 2}), "trial.mat");
        },
        Code::file_damaged, "trial.mat");
  }
  CHECK(mat_version("too short") == MatVersion::none);
  check_error(
      [] {
        read_mat_4(bytes_of<std::uint32_t>({0, 4'000'000'000, 4'000'000'000, 0, 1}, true) + '\0', "trial.mat");
      },
      Code::file_too_large, "trial.mat");
  // No rows, none of 4 billion columns, and one name for all of 10,001.
  std::string many;
  for (int i = 0; i < max_mat_variables; ++i) many += bytes_of<std::uint32_t>({0, 0, 4'000'000'000, 0, 1}, true) + '\0';
  CHECK(read_mat_4(many, "x").size() == std::size_t{max_mat_variables});
  check_error([&] { read_mat_4(many + many.substr(0, 21), "trial.mat"); }, Code::file_too_large, "10000 variables");
}

TEST_CASE("version 5: numbers of every type, in either byte order") {
  const std::vector<double> expected{3.0, 100.0};
  for (const bool little : {true, false}) {
    const Mat5 mat{little};
    // A class of whole numbers or not: how they are stored is another matter, as MATLAB stores what fits in fewer
    // bytes.
    const auto read = [&](std::uint32_t type, const std::string& data) {
      return only(read_mat_5(mat.file(mat.matrix(mat.head(double_class, 2, 1) + mat.element(type, data))), "x"));
    };
    CHECK(read(1, bytes_of<std::int8_t>({3, 100}, little)) == expected);
    CHECK(read(2, bytes_of<std::uint8_t>({3, 100}, little)) == expected);
    CHECK(read(3, bytes_of<std::int16_t>({3, 100}, little)) == expected);
    CHECK(read(4, bytes_of<std::uint16_t>({3, 100}, little)) == expected);
    CHECK(read(5, bytes_of<std::int32_t>({3, 100}, little)) == expected);
    CHECK(read(6, bytes_of<std::uint32_t>({3, 100}, little)) == expected);
    CHECK(read(7, bytes_of<float>({3, 100}, little)) == expected);
    CHECK(read(9, bytes_of<double>({3, 100}, little)) == expected);
    CHECK(read(12, bytes_of<std::int64_t>({3, 100}, little)) == expected);
    CHECK(read(13, bytes_of<std::uint64_t>({3, 100}, little)) == expected);
    check_error([&] { read(8, std::string(16, '\0')); }, Code::file_damaged);
    check_error([&] { read(9, bytes_of<double>({3}, little)); }, Code::file_damaged);
    CHECK(mat_version(mat.file("")) == MatVersion::v5);
  }
  const Mat5 mat;
  CHECK(only(read_mat_5(
            mat.file(mat.matrix(mat.head(double_class, 2, 1) + mat.small(3, bytes_of<std::int16_t>({3, -4}, true)))),
            "x")) == std::vector{3.0, -4.0});
  CHECK(mat_version(std::string(124, ' ') + std::string("\x00\x02IM", 4)) == MatVersion::v73);
  CHECK(mat_version(std::string(124, ' ') + std::string("\x02\x00MI", 4)) == MatVersion::v73);
  CHECK(mat_version(std::string(128, ' ')) == MatVersion::none);
}

TEST_CASE("version 5: every class has its kind") {
  const Mat5 mat;
  const std::string fields = mat.small(5, bytes_of<std::int32_t>({8}, true)) + mat.element(1, "");
  const auto read = [&](std::uint32_t kind) {
    const auto variables = read_mat_5(mat.file(mat.matrix(mat.head(kind, 1, 0) + fields)), "x");
    REQUIRE(variables.size() == 1);
    return variables[0].kind;
  };
  const Kind kinds[]{Kind::cell, Kind::structure, Kind::object, Kind::text, Kind::sparse, Kind::numbers};
  for (std::uint32_t i = 0; i < 6; ++i) CHECK(read(i + 1) == kinds[i]);
  CHECK(read(uint32_class) == Kind::numbers);
  CHECK(read(16) == Kind::function);
  CHECK(read(double_class | 0x0800) == Kind::complex);
  for (const std::uint32_t none : {0u, 18u, 255u})
    check_error(reading_5(mat.matrix(mat.head(none, 1, 0))), Code::file_damaged, "trial.mat");
  // MATLAB's own objects: only their class is read, and a variable without a name is ignored.
  const std::string flags = mat.element(6, bytes_of<std::uint32_t>({17, 0}, true));
  const auto objects = read_mat_5(mat.file(mat.matrix(flags + mat.element(1, "table")) +
                                           mat.matrix(flags + mat.element(1, "")) + mat.element(9, "")),
                                  "x");
  REQUIRE(objects.size() == 1);
  CHECK(objects[0].kind == Kind::object);
  CHECK(objects[0].name == "table");
  // Three dimensions are pages; four are not read.
  const auto of_sizes = [&](std::initializer_list<std::int32_t> sizes) {
    return read_mat_5(mat.file(mat.matrix(mat.element(6, bytes_of<std::uint32_t>({6, 0}, true)) +
                                          mat.element(5, bytes_of<std::int32_t>(sizes, true)) + mat.element(1, "x") +
                                          mat.element(1, std::string("\1\2\3\4\5\6")))),
                      "x");
  };
  const auto cube = of_sizes({1, 2, 3}), more = of_sizes({1, 1, 2, 3});
  REQUIRE(cube.size() == 1);
  CHECK(cube[0].is_matrix);
  CHECK(cube[0].pages == 3);
  CHECK(cube[0].values == std::vector{1.0, 2.0, 3.0, 4.0, 5.0, 6.0});
  REQUIRE(more.size() == 1);
  CHECK_FALSE(more[0].is_matrix);
  CHECK(more[0].values.empty());
  check_error([&] { of_sizes({1000, 1000, 1000}); }, Code::file_too_large);
  check_error([&] { of_sizes({1, 2, -3}); }, Code::file_damaged);
}

TEST_CASE("version 5: structures have fields, arrays of them and cells elements") {
  const Mat5 mat;
  const std::string field =
      mat.matrix(mat.head(double_class, 2, 1, "") + mat.element(9, bytes_of<double>({1, 2}, true)));
  const auto read = [&](std::int32_t height, std::int32_t width, std::int32_t each, const std::string& names,
                        const std::string& fields) {
    const auto variables = read_mat_5(
        mat.file(mat.matrix(mat.head(struct_class, height, width) + mat.small(5, bytes_of<std::int32_t>({each}, true)) +
                            mat.element(1, names) + fields)),
        "trial.mat");
    REQUIRE(variables.size() == 1);
    return variables[0].fields;
  };
  const std::string names("time\0\0\0\0sway\0\0\0\0", 16);
  const auto fields = read(1, 1, 8, names, field + mat.matrix(""));
  REQUIRE(fields.size() == 2);
  CHECK(fields[0].name == "time");
  CHECK(fields[0].values == std::vector{1.0, 2.0});
  CHECK(fields[1].name == "sway");  // an empty field
  CHECK(fields[1].values.empty());
  CHECK(read(1, 1, 8, names, field).size() == 1);
  for (const auto& [height, width] : {std::pair{2, 1}, std::pair{1, 2}}) {
    const auto elements = read(height, width, 8, names, field + mat.matrix("") + field + field);
    REQUIRE(elements.size() == 2);
    CHECK(elements[1].name == "(2)");
    REQUIRE(elements[1].fields.size() == 2);
    CHECK(elements[0].fields[1].values.empty());
    CHECK(elements[1].fields[1].name == "sway");
    CHECK(elements[1].fields[1].values == std::vector{1.0, 2.0});
  }
  CHECK(read(2, 1, 8, names, field + field).size() == 1);
  CHECK(read(0, 1, 8, names, "").empty());
  CHECK(read(100, 100, 8, names, field).empty());  // as many as a file may hold
  CHECK(read(2'000'000'000, 2'000'000'000, 8, names, field).empty());
  const auto cells = [&](std::int32_t count, const std::string& inner) {
    return read_mat_5(mat.file(mat.matrix(mat.head(1, count, 1) + inner)), "trial.mat").front().fields;
  };
  REQUIRE(cells(2, field + mat.matrix("")).size() == 2);
  CHECK(cells(2, field + field)[1].name == "{2}");
  CHECK(cells(2, field + field)[1].values == std::vector{1.0, 2.0});
  CHECK(cells(2, field).size() == 1);
  CHECK(cells(6000, field).empty());
  check_error([&] { cells(2, mat.element(9, bytes_of<double>({1, 2}, true))); }, Code::file_damaged, "trial.mat");
  CHECK(read(1, 1, 0, names, field + field).empty());
  CHECK(read(1, 1, 8, "", "").empty());
  check_error(
      [&] {
        read(1, 1, 8, names, mat.element(9, bytes_of<double>({1, 2}, true)));
      },
      Code::file_damaged, "trial.mat");
  check_error(reading_5(mat.matrix(mat.head(struct_class, 1, 1) + mat.small(6, bytes_of<std::uint32_t>({8}, true)) +
                                   mat.element(1, names) + field)),
              Code::file_damaged, "trial.mat");
  // Deeper than is read: there, and empty.
  std::string deep =
      mat.head(struct_class, 1, 1, "") + mat.small(5, bytes_of<std::int32_t>({8}, true)) + mat.element(1, "");
  for (int depth = 0; depth < deepest_structure + 2; ++depth)
    deep = mat.head(struct_class, 1, 1, depth == deepest_structure + 1 ? "x" : "") +
           mat.small(5, bytes_of<std::int32_t>({8}, true)) + mat.element(1, names.substr(0, 8)) + mat.matrix(deep);
  const auto outermost = read_mat_5(mat.file(mat.matrix(deep)), "x");
  REQUIRE(outermost.size() == 1);
  int depth = 0;
  for (const MatVariable* at = &outermost[0]; !at->fields.empty(); at = &at->fields[0]) ++depth;
  CHECK(depth == deepest_structure);
}

TEST_CASE("version 5: text has rows, an object its class") {
  const Mat5 mat;
  const auto read = [&](std::int32_t height, std::int32_t width, const std::string& data) {
    return read_mat_5(mat.file(mat.matrix(mat.head(4, height, width) + data)), "x").front().text;
  };
  using Strings = std::vector<std::string>;
  CHECK(read(1, 4, mat.element(1, "sway")) == Strings{"sway"});
  CHECK(read(2, 3, mat.element(2, "axby c")) == Strings{"ab", "xyc"});
  CHECK(read(2, 2, mat.element(2, "ab  ")) == Strings{"a", "b"});
  CHECK(read(1, 3, mat.element(16, "m\xC2\xB0\xE2\x82\xAC")) == Strings{"m\xC2\xB0\xE2\x82\xAC"});
  CHECK(read(1, 1, mat.element(16, "\xF0\x9F\x99\x82")) == Strings{"\xF0\x9F\x99\x82"});
  CHECK(read(1, 2, mat.element(17, bytes_of<std::uint16_t>({0xB0, 0x20AC}, true))) == Strings{"\xC2\xB0\xE2\x82\xAC"});
  CHECK(read(1, 2, mat.element(4, bytes_of<std::uint16_t>({'d', 0xD800}, true))) == Strings{"d?"});
  CHECK(read(1, 1, mat.element(18, bytes_of<std::uint32_t>({0x1F642}, true))) == Strings{"\xF0\x9F\x99\x82"});
  CHECK(read(1, 9, mat.element(1, "short")).empty());
  CHECK(read(0, 0, mat.element(1, "")).empty());
  CHECK(read(2'000'000'000, 0, mat.element(1, "")).empty());
  CHECK(read(2'000'000'000, 2'000'000'000, mat.element(1, "")).empty());
  const std::string flags = mat.element(6, bytes_of<std::uint32_t>({17, 0}, true));
  const std::string object =
      mat.file(mat.matrix(flags + mat.element(1, "ts") + mat.element(1, "MCOS") + mat.element(1, "timeseries")));
  CHECK(read_mat_5(object, "x").front().text == Strings{"timeseries"});
  check_error([&] { MatTable(object, "trial.mat"); }, Code::file_empty, "ts.Time");
  const std::string table =
      mat.file(mat.matrix(flags + mat.element(1, "T") + mat.element(1, "MCOS") + mat.element(1, "timetable")));
  check_error([&] { MatTable(table, "trial.mat"); }, Code::file_empty);
}

TEST_CASE("version 5: a matrix that begins or claims otherwise is refused") {
  const Mat5 mat;
  const std::string flags = mat.element(6, bytes_of<std::uint32_t>({6, 0}, true)), name = mat.element(1, "x");
  check_error(reading_5(mat.matrix(mat.element(5, bytes_of<std::int32_t>({6, 0}, true)))), Code::file_damaged,
              "trial.mat");
  check_error(reading_5(mat.matrix(mat.small(6, "ab"))), Code::file_damaged);
  check_error(reading_5(mat.matrix(flags + mat.element(6, bytes_of<std::uint32_t>({2, 1}, true)) + name)),
              Code::file_damaged);
  check_error(reading_5(mat.matrix(flags + mat.size(-1, 1) + name)), Code::file_damaged);
  check_error(reading_5(mat.matrix(flags + mat.size(1, -1) + name)), Code::file_damaged);
  check_error(reading_5(mat.matrix(mat.head(double_class, 1, 1, std::string(2000, 'n')))), Code::file_damaged);
  check_error(reading_5(mat.matrix(mat.head(double_class, 2'000'000'000, 2'000'000'000))), Code::file_too_large);
  check_error(reading_5(mat.matrix(mat.head(double_class, 10'000'001, 1))), Code::file_too_large, "10 million");
  check_error(reading_5(bytes_of<std::uint32_t>({5u << 16 | 1, 0}, true)), Code::file_damaged);
  CHECK(read_mat_5(mat.file(mat.matrix("")), "x").empty());
  CHECK(only(read_mat_5(
                 mat.file(mat.matrix(mat.head(double_class, 2, 1) + mat.element(9, bytes_of<double>({1, 2}, true)))),
                 "x"))
            .size() == 2);
  std::string many;
  for (int i = 0; i < max_mat_variables; ++i) many += mat.matrix(mat.head(double_class, 0, 1));
  CHECK(read_mat_5(mat.file(many), "x").size() == std::size_t{max_mat_variables});
  check_error(reading_5(many + mat.matrix(mat.head(double_class, 0, 1))), Code::file_too_large, "10000 variables");
}

TEST_CASE("version 7: a compressed element is one whole matrix of its stated length") {
  const Mat5 mat;
  const std::string whole = mat.matrix(mat.head(double_class, 2, 1) + mat.element(9, bytes_of<double>({3, 4}, true)));
  CHECK(only(read_mat_5(mat.file(deflated(whole)), "x")) == std::vector{3.0, 4.0});
  CHECK(read_mat_5(mat.file(deflated(mat.matrix(""))), "x").empty());
  CHECK(read_mat_5(mat.file(deflated(mat.element(9, bytes_of<double>({3, 4}, true)))), "x").empty());
  check_error(reading_5(deflated("short")), Code::file_damaged);
  check_error(reading_5(deflated(whole.substr(0, whole.size() - 8))), Code::file_damaged);
  check_error(reading_5(deflated(whole + std::string(64, '\0'))), Code::file_damaged);
  check_error(reading_5(mat.tag(15, 16) + std::string(16, 'z')), Code::file_damaged);
}

TEST_CASE("kinds of variables that are no columns are named; wide and narrow matrices have theirs by number") {
  const TemporaryFolder folder;
  const Mat5 mat;
  const std::string fields = mat.small(5, bytes_of<std::int32_t>({8}, true)) + mat.element(1, "");
  const std::string nothing =
      mat.file(mat.matrix(mat.head(5, 3, 1, "s")) + mat.matrix(mat.head(16, 1, 1, "f")) +
               mat.matrix(mat.head(3, 1, 1, "o")) + mat.matrix(mat.head(struct_class, 2, 1, "t") + fields));
  check_error([&] { MatTable(nothing, "trial.mat"); }, Code::file_empty, "3 x");
  check_error([&] { MatTable(mat.file(""), "trial.mat"); }, Code::file_empty, "trial.mat");
  check_error(
      [&] {
        MatTable(mat.file(mat.matrix(mat.head(double_class, 1002, 1001, "m") +
                                     mat.element(1, std::string(1002 * 1001, '\x01')))),
                 "trial.mat");
      },
      Code::file_too_large, "1001 columns");
  const MatTable table(
      mat.file(mat.matrix(mat.head(double_class, 1, 1, "fs") + mat.small(1, "\x32")) +
               mat.matrix(mat.head(double_class, 2, 3, "w") + mat.element(1, std::string("\1\2\3\4\5\6")))),
      "trial.mat");
  REQUIRE(table.stated_rates().size() == 1);
  CHECK(table.stated_rates()[0].hz == 50.0);
  CHECK(table.columns() == 2);
  CHECK(table.numbers(0, Missing::refused) == std::vector{1.0, 3.0, 5.0});
  CHECK(table.numbers(1, Missing::refused) == std::vector{2.0, 4.0, 6.0});
  const double infinite = std::numeric_limits<double>::infinity();
  const MatTable bad(
      mat.file(mat.matrix(mat.head(double_class, 2, 1) + mat.element(9, bytes_of<double>({1, infinite}, true)))),
      "trial.mat");
  check_error([&] { bad.numbers(0, Missing::kept); }, Code::value_invalid, "trial.mat");
  const double missing = std::numeric_limits<double>::quiet_NaN();
  const MatTable labelled(
      mat.file(mat.matrix(mat.head(double_class, 4, 1) + mat.element(9, bytes_of<double>({1, missing, 2.5, 1}, true)))),
      "trial.mat");
  CHECK(labelled.labels(0).values == std::vector<std::string>{"1", "", "2.5"});
  CHECK(labelled.labels(0).of_row == std::vector<std::uint32_t>{0, 1, 2, 0});
}
