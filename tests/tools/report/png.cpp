// PNG files: the test parses each chunk, computes every checksum with zlib and compares every pixel. Base64 of RFC
// 4648.
#include "tools/report/figures/png.hpp"

#include <doctest/doctest.h>
#include <zlib.h>

#include "base/error.hpp"
#include "base/math/random.hpp"

namespace decid::tools {
namespace {

std::uint32_t number_at(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<std::uint8_t>(bytes.at(at + i));
  return value;
}

struct Chunk {
  std::string type, content;
};
std::vector<Chunk> chunks_of(std::string_view file) {
  REQUIRE(file.starts_with("\x89PNG\r\n\x1a\n"));
  std::vector<Chunk> chunks;
  for (std::size_t at = 8; at < file.size();) {
    REQUIRE(file.size() - at >= 12);
    const std::size_t length = number_at(file, at);
    REQUIRE(file.size() - at >= 12 + length);
    const std::string_view body = file.substr(at + 4, 4 + length);
    CHECK(number_at(file, at + 8 + length) ==
          crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size())));
    chunks.push_back({std::string(body.substr(0, 4)), std::string(body.substr(4))});
    at += 12 + length;
  }
  return chunks;
}

Bitmap random_bitmap(int width, int height, int channels) {
  Bitmap bitmap(width, height, channels);
  const Random random(7, Stream::shuffle, static_cast<std::uint64_t>(width));
  for (std::size_t i = 0; i < bitmap.values.size(); ++i)
    bitmap.values[i] = static_cast<std::uint8_t>(random.below(i, 256));
  return bitmap;
}

}  // namespace

TEST_CASE("png: a file of three chunks holds the size, the colours and every pixel") {
  struct Case {
    int width, height, channels;
  };
  for (const Case& c : {Case{1, 1, 1}, {3, 2, 3}, {300, 5, 1}, {7, 260, 3}, {110, 110, 3}}) {
    CAPTURE(c.width);
    CAPTURE(c.channels);
    const Bitmap bitmap = random_bitmap(c.width, c.height, c.channels);
    const std::vector<Chunk> chunks = chunks_of(png(bitmap));
    REQUIRE(chunks.size() == 3);

    CHECK(chunks[0].type == "IHDR");
    REQUIRE(chunks[0].content.size() == 13);
    CHECK(number_at(chunks[0].content, 0) == static_cast<std::uint32_t>(c.width));
    CHECK(number_at(chunks[0].content, 4) == static_cast<std::uint32_t>(c.height));
    CHECK(chunks[0].content[8] == 8);                          // bits a value
    CHECK(chunks[0].content[9] == (c.channels == 3 ? 2 : 0));  // colour type
    CHECK(chunks[0].content.substr(10) == std::string(3, '\0'));

    CHECK(chunks[1].type == "IDAT");
    const std::size_t row = static_cast<std::size_t>(c.width * c.channels), rows = static_cast<std::size_t>(c.height);
    std::vector<std::uint8_t> lines(rows * (1 + row) + 1);
    uLongf length = static_cast<uLongf>(lines.size());
    REQUIRE(uncompress(lines.data(), &length, reinterpret_cast<const Bytef*>(chunks[1].content.data()),
                       static_cast<uLong>(chunks[1].content.size())) == Z_OK);
    REQUIRE(length == rows * (1 + row));
    std::vector<std::uint8_t> pixels;
    for (std::size_t r = 0; r < rows; ++r) {
      const auto line = lines.begin() + static_cast<std::ptrdiff_t>(r * (1 + row));
      CHECK(*line == 0);  // no filter
      pixels.insert(pixels.end(), line + 1, line + 1 + static_cast<std::ptrdiff_t>(row));
    }
    CHECK(pixels == bitmap.values);

    CHECK(chunks[2].type == "IEND");
    CHECK(chunks[2].content.empty());
  }
}

TEST_CASE("png: a bitmap's pixels are rows from the top, colours together, white at first") {
  Bitmap bitmap(3, 2, 3);
  CHECK(bitmap.values == std::vector<std::uint8_t>(18, 255));
  bitmap.at(1, 2, 1) = 200;
  bitmap.at(0, 1) = 100;
  CHECK(bitmap.values[16] == 200);
  CHECK(bitmap.values[3] == 100);
}

TEST_CASE("png: what cannot be a picture, and what compresses") {
  CHECK_THROWS_AS(png(Bitmap(0, 2, 1)), Error);
  CHECK_THROWS_AS(png(Bitmap(2, 0, 3)), Error);
  CHECK(png(Bitmap(1000, 1000, 3)).size() < 10'000);
}

TEST_CASE("base64 of RFC 4648") {
  CHECK(base64("") == "");
  CHECK(base64("f") == "Zg==");
  CHECK(base64("fo") == "Zm8=");
  CHECK(base64("foo") == "Zm9v");
  CHECK(base64("foobar") == "Zm9vYmFy");
  CHECK(base64(std::string("\xff\x00\xfe", 3)) == "/wD+");
}

}  // namespace decid::tools
