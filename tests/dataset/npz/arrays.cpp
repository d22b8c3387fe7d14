// Arrays on disk: header and values as NumPy has them, errors that leave no file.
#include "dataset/npz/arrays.hpp"

#include <cstring>

#include "base/files/file.hpp"
#include "dataset/npz/detail/npy.hpp"
#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::dataset;
using namespace decid::test;

TEST_CASE("write_arrays: each member is a header and its values, whose place is a multiple of 64 bytes") {
  const TemporaryFolder folder;
  const std::vector<double> matrix{1.0, -2.5, 3.25, 4.0, 1e300, -0.0}, column{7.0, 8.0};
  const NamedArray arrays[] = {{"matrix", {2, 3}, matrix}, {"2/gain", {2}, column}};
  write_arrays(folder / "a.npz", arrays);
  const std::string content = read_file(folder / "a.npz");
  for (const NamedArray& array : arrays) {
    const std::size_t name = content.find(array.name + ".npy");
    REQUIRE(name != std::string::npos);
    const std::size_t header = content.find("\x93NUMPY", name);
    REQUIRE(header != std::string::npos);
    CHECK(header % 64 == 0);
    const NpyHeader read = parse_npy_header(std::string_view(content).substr(header), "a.npz");
    CHECK(read.type == "<f8");
    CHECK(read.shape == array.shape);
    CHECK(std::memcmp(content.data() + header + read.bytes, array.values.data(), array.values.size_bytes()) == 0);
  }
}

TEST_CASE("write_arrays: errors") {
  const TemporaryFolder folder;
  const std::vector<double> values{1.0, 2.0};
  const NamedArray wrong[] = {{"a", {3}, values}};
  check_error([&] { write_arrays(folder / "a.npz", wrong); }, Code::size_mismatch, "2 values");
  CHECK_FALSE(std::filesystem::exists(folder / "a.npz"));
  const NamedArray right[] = {{"a", {2}, values}};
  check_error([&] { write_arrays(folder / "none/a.npz", right); }, Code::file_unwritable, "a.npz");
  check_error([&] { write_arrays("/dev/null", right); }, Code::file_unwritable, "/dev/null");
}
