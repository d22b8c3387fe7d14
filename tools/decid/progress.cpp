// Progress of long work: see progress.hpp.
#include "tools/decid/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "base/text.hpp"

namespace decid::tools {

namespace {

/// Returns the number of UTF-8 characters: bytes that do not continue a character.
std::size_t characters(const std::string& text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char byte) { return (static_cast<unsigned char>(byte) & 0xc0) != 0x80; }));
}

}  // namespace

std::string curve(std::span<const double> values, std::size_t max_length) {
  constexpr std::array<const char*, 8> levels{"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  std::vector<double> heights(values.begin(), values.end());
  if (values.size() > max_length)
    heights.erase(heights.begin(), heights.end() - static_cast<std::ptrdiff_t>(max_length));
  if (std::ranges::all_of(heights, [](double value) { return value > 0.0; }))
    for (double& value : heights) value = std::log(value);
  if (heights.empty()) return {};
  const auto [low, high] = std::ranges::minmax(heights);
  std::string text;
  for (const double height : heights) {
    const double fraction = high > low ? (height - low) / (high - low) : 0.0;
    text += levels.at(static_cast<std::size_t>(std::lround(fraction * (levels.size() - 1))));
  }
  return text;
}

ProgressBar::ProgressBar(std::string what, std::string unit, long long total, bool quiet, int parts)
    : what_(std::move(what)),
      unit_(std::move(unit)),
      total_(std::max(total, 1LL) * parts),
      parts_(parts),
      quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) != 0),
      start_(std::chrono::steady_clock::now()),
      next_(start_ + std::chrono::milliseconds(terminal_ ? 200 : 10000)) {}

ProgressBar::~ProgressBar() {
  clear();
}

std::string ProgressBar::figures(long long done) const {
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  const double rate = static_cast<double>(done - before_) / std::max(seconds, 1e-9);
  const double units = rate / parts_;
  const std::string left =
      done > before_ ? ", about " + duration_text(static_cast<double>(total_ - done) / rate) + " left" : "";
  if (unit_ == "%") return format("%lld%%", 100 * done / total_) + left;
  const std::string count = parts_ == 1 ? std::to_string(done) : format("%.1f", static_cast<double>(done) / parts_);
  return format("%s of %lld %s, %.*f/s", count.c_str(), total_ / parts_, unit_.c_str(), units < 10 ? 2 : 0, units) +
         left;
}

void ProgressBar::go_on_from(long long done) {
  before_ = done;
  start_ = std::chrono::steady_clock::now();
}

void ProgressBar::update(long long done, const std::string& note) {
  const auto now = std::chrono::steady_clock::now();
  if (quiet_ || now < next_) return;
  next_ = now + std::chrono::milliseconds(terminal_ ? 200 : 10000);
  std::string text = what_ + ": ";
  if (terminal_) {
    constexpr long long width = 24;
    const auto filled = static_cast<std::size_t>(width * std::min(done, total_) / total_);
    text += "[" + std::string(filled, '#') + std::string(width - filled, '.') + "] ";
  }
  text += figures(done);
  if (!note.empty()) text += ", " + note;
  if (!terminal_) {
    std::fprintf(stderr, "%s\n", text.c_str());
    return;
  }
  const std::size_t width = characters(text), padding = width < shown_ ? shown_ - width : 0;
  std::fprintf(stderr, "\r%s%s", text.c_str(), std::string(padding, ' ').c_str());
  std::fflush(stderr);
  shown_ = width;
}

void ProgressBar::line(const std::string& text) {
  if (quiet_) return;
  clear();
  std::fprintf(stderr, "%s\n", text.c_str());
}

void ProgressBar::clear() {
  if (shown_ > 0) std::fprintf(stderr, "\r%s\r", std::string(shown_, ' ').c_str());
  shown_ = 0;
}

}  // namespace decid::tools
