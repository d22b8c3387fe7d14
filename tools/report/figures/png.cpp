// Bitmaps as PNG: see png.hpp.
#include "tools/report/figures/png.hpp"

#include <zlib.h>

#include "base/error.hpp"

namespace decid::tools {
namespace {

void add_number(std::string& bytes, std::uint32_t value) {
  for (const int shift : {24, 16, 8, 0}) bytes += static_cast<char>((value >> shift) & 0xff);
}

void add_chunk(std::string& file, const std::string& type, const std::string& content) {
  add_number(file, static_cast<std::uint32_t>(content.size()));
  const std::string body = type + content;
  file += body;
  add_number(file, static_cast<std::uint32_t>(
                       crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()))));
}

}  // namespace

std::string png(const Bitmap& bitmap) {
  if (bitmap.width < 1 || bitmap.height < 1)
    throw Error(Code::setting_out_of_range, "png", "a bitmap without pixels", "give it a size");
  const auto row = static_cast<std::size_t>(bitmap.width) * static_cast<std::size_t>(bitmap.channels);
  std::string lines;
  for (std::size_t begin = 0; begin < bitmap.values.size(); begin += row) {
    lines += '\0';  // no filter
    lines.append(reinterpret_cast<const char*>(bitmap.values.data()) + begin, row);
  }
  uLongf size = compressBound(static_cast<uLong>(lines.size()));
  std::string packed(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(lines.data()),
                static_cast<uLong>(lines.size()), Z_BEST_COMPRESSION) != Z_OK)
    throw Error(Code::system_failed, "png", "cannot be compressed", "free some memory");
  packed.resize(size);

  std::string header;
  add_number(header, static_cast<std::uint32_t>(bitmap.width));
  add_number(header, static_cast<std::uint32_t>(bitmap.height));
  header += {8, static_cast<char>(bitmap.channels == 3 ? 2 : 0), 0, 0, 0};  // bits, colour type, the only methods
  std::string file = "\x89PNG\r\n\x1a\n";
  add_chunk(file, "IHDR", header);
  add_chunk(file, "IDAT", packed);
  add_chunk(file, "IEND", "");
  return file;
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? digits[(group >> (18 - 6 * k)) & 63] : '=';
  }
  return text;
}

}  // namespace decid::tools
