// Bitmaps as PNG (ISO/IEC 15948), 8 bits a value, for the heat maps inside SVG figures; compressed by zlib.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace decid::tools {

struct Bitmap {
  int width = 0, height = 0, channels = 1;  ///< 1: grey, 3: red, green, blue
  std::vector<std::uint8_t> values;         ///< rows from the top, height x width x channels

  Bitmap(int width_, int height_, int channels_, std::uint8_t value = 255)
      : width(width_),
        height(height_),
        channels(channels_),
        values(
            static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) * static_cast<std::size_t>(channels_),
            value) {}
  std::uint8_t& at(int row, int column, int channel = 0) {
    return values[(static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column)) *
                      static_cast<std::size_t>(channels) +
                  static_cast<std::size_t>(channel)];
  }
};

/// Returns the bytes of the file. Throws Error for an empty bitmap.
std::string png(const Bitmap& bitmap);

/// Returns base64 of RFC 4648, with padding.
std::string base64(std::string_view bytes);

}  // namespace decid::tools
