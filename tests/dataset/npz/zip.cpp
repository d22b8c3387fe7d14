// Zip archives: checksums, alignment, and what is larger than 4 GiB, in a file with a hole and as Python reads it.
#include "dataset/npz/detail/zip.hpp"

#include <cstdlib>
#include <stdexcept>

#include "dataset/npz/detail/npz_parts.hpp"
#include "dataset/npz/npz.hpp"
#include "tests/helpers.hpp"
#include "tests/sim/tiny_protocol.hpp"

using namespace decid;
using namespace decid::dataset;
using namespace decid::test;

namespace {

std::uint32_t crc32_of(std::string_view text) {
  return crc32(std::as_bytes(std::span(text)));
}

/// CRC-32 of that many zeros, by joining halves.
std::uint32_t crc32_of_zeros(std::uint64_t bytes) {
  if (bytes == 0) return 0;
  if (bytes == 1) return crc32_of(std::string_view("\0", 1));
  const std::uint32_t half = crc32_of_zeros(bytes / 2);
  const std::uint32_t even = crc32_joined(half, half, bytes / 2);
  return bytes % 2 == 0 ? even : crc32_joined(even, crc32_of_zeros(1), 1);
}

std::uint64_t number(const std::string& text, std::size_t at, int bytes) {
  std::uint64_t value = 0;
  for (int i = 0; i < bytes; ++i)
    value |= std::uint64_t{static_cast<unsigned char>(text[at + static_cast<std::size_t>(i)])} << (8 * i);
  return value;
}

}  // namespace

TEST_CASE("checksums") {
  CHECK(crc32_of("123456789") == 0xcbf43926);  // the check value of CRC-32/ISO-HDLC
  CHECK(crc32_of("") == 0);
  const std::string text = "the same in one piece and in several";
  for (std::size_t cut = 0; cut <= text.size(); ++cut) {
    const std::string_view a = std::string_view(text).substr(0, cut), b = std::string_view(text).substr(cut);
    CHECK(crc32_joined(crc32_of(a), crc32_of(b), b.size()) == crc32_of(text));
    const std::span<const std::byte> pieces[]{std::as_bytes(std::span(a)), {}, std::as_bytes(std::span(b))};
    CHECK(crc32(pieces) == crc32_of(text));
  }
  CHECK(crc32_of_zeros(1000) == crc32_of(std::string(1000, '\0')));
}

TEST_CASE("contents start at multiples of 64 bytes") {
  for (std::uint64_t offset = 0; offset < 130; ++offset) {
    for (const std::uint64_t bytes : {std::uint64_t{5}, std::uint64_t{1} << 33}) {
      const std::string header = zip_local_header({"sway.npy", bytes, offset, 7});
      REQUIRE((offset + header.size()) % 64 == 0);
      REQUIRE(header.size() == 30 + number(header, 26, 2) + number(header, 28, 2));
      REQUIRE(header.size() < 30 + 8 + 20 + 6 + 64);
      REQUIRE(header.size() == zip_local_header({"sway.npy", bytes, offset, 0}).size());
    }
  }
}

TEST_CASE("sizes and offsets go into ZIP64 fields when they need them, and not before") {
  constexpr std::uint64_t limit = 0xffffffff;
  const std::string below = zip_local_header({"a", limit - 1, 0, 0});
  CHECK(number(below, 18, 4) == limit - 1);
  CHECK(number(below, 4, 2) == 20);       // version needed
  CHECK(number(below, 31, 2) == 0xd935);  // padding is the only extra field
  const std::string at = zip_local_header({"a", limit, 0, 0});
  CHECK(number(at, 4, 2) == 45);
  CHECK(number(at, 18, 4) == limit);
  CHECK(number(at, 22, 4) == limit);
  CHECK(number(at, 31, 2) == 1);
  CHECK(number(at, 33, 2) == 16);
  CHECK(number(at, 35, 8) == limit);
  CHECK(number(at, 43, 8) == limit);

  const std::uint64_t far = 7'000'000'000;
  const ZipMember members[]{{"a", 6'000'000'000, 0, 1}, {"b", 9, far, 2}};
  const std::string directory = zip_directory(members, far + 100);
  CHECK(number(directory, 0, 4) == 0x02014b50);
  CHECK(number(directory, 30, 2) == 20);  // a: both sizes, not the offset
  CHECK(number(directory, 47 + 4, 8) == 6'000'000'000);
  const std::size_t b = 46 + 1 + 20;
  CHECK(number(directory, b, 4) == 0x02014b50);
  CHECK(number(directory, b + 20, 4) == 9);
  CHECK(number(directory, b + 30, 2) == 12);  // b: the offset alone
  CHECK(number(directory, b + 42, 4) == limit);
  CHECK(number(directory, b + 47 + 4, 8) == far);
  const std::size_t end64 = b + 46 + 1 + 12;
  CHECK(number(directory, end64, 4) == 0x06064b50);
  CHECK(number(directory, end64 + 48, 8) == far + 100);
  CHECK(number(directory, end64 + 56, 4) == 0x07064b50);
  CHECK(number(directory, end64 + 64, 8) == far + 100 + end64);
  CHECK(number(directory, end64 + 76, 4) == 0x06054b50);
  CHECK(directory.size() == end64 + 98);
  CHECK_FALSE(contains(zip_directory(std::span(members).subspan(1), 100), "PK\x06\x06"));
}

TEST_CASE("members that are not as long as announced are a mistake of ours") {
  const TemporaryFolder folder;
  DiskFile file(folder / "a.zip", DiskFile::Access::write);
  ZipWriter zip(file);
  zip.begin("a", 4);
  CHECK_THROWS_AS(zip.end(), std::logic_error);
  CHECK_THROWS_AS(zip.begin("b", 4), std::logic_error);
  CHECK_THROWS_AS(zip.write(std::as_bytes(std::span("12345", 5))), std::logic_error);
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST_CASE("a data set of more than 4 GiB, all zeros and a hole in the file, is read by decid and by Python" *
          doctest::test_suite("long")) {
  const TemporaryFolder folder;
  sim::Protocol protocol = tiny_protocol();
  protocol.sequence().lead_out_s = 3000.0;
  const auto samples = static_cast<std::size_t>(protocol.samples());
  const std::size_t trials = 3600;
  const std::uint64_t bytes = trials * samples * sizeof(float);
  REQUIRE(bytes > std::uint64_t{1} << 32);
  const auto path = folder / "large.npz";
  {
    DiskFile file(path, DiskFile::Access::write);
    ZipWriter zip(file);
    begin_array<float>(zip, "sway", {trials, samples});
    zip.skip(bytes, crc32_of_zeros(bytes));
    zip.end();
    begin_array<double>(zip, "parameters", {trials, sim::single_pendulum().parameters.size()});
    const std::vector<sim::Parameters> parameters(trials, sim::single_pendulum().parameters.middle());
    zip.write(parameter_bytes(parameters));
    zip.end();
    std::vector<std::int32_t> group(trials);
    for (std::size_t i = 0; i < trials; ++i) group[i] = static_cast<std::int32_t>(i);
    finish_archive(zip, group, split_by_group(group), describe(protocol, 1));
  }
  const StoredDataset data(path);
  CHECK_FALSE(data.in_memory());
  CHECK(data.trials() == 3600);
  std::vector<float> sway(samples, 1.0f);
  data.read(3599, sway);
  CHECK(sway == std::vector<float>(samples, 0.0f));

  if (std::system("/usr/bin/python3 -c 'import numpy' 2>/dev/null") != 0) return;
  write_text(folder / "check.py", R"(
import sys, zipfile
import numpy as np
archive = zipfile.ZipFile(sys.argv[1])
sizes = {i.filename: (i.file_size, i.header_offset) for i in archive.infolist()}
assert sizes['sway.npy'][0] > 2**32 and sizes['sway.npy'][1] == 0, sizes
assert sizes['group.npy'][1] > 2**32, sizes
assert np.load(sys.argv[1])['group'].tolist() == list(range(3600))
with archive.open('sway.npy') as sway: assert sway.read(6) == b'\x93NUMPY'
)");
  const std::string check = (folder / "check.py").string();
  CHECK(std::system(("/usr/bin/python3 " + check + " " + path.string()).c_str()) == 0);
}
#endif
