// Writes C3D files for tests: points and analog channels, as each of the format's processors writes them.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace decid::test {

inline constexpr unsigned intel = 84, dec = 85, mips = 86;

/// A file in the making. Parameters may be set, changed (`parameters`, by "GROUP:NAME") and erased before bytes().
class C3dFile {
 public:
  explicit C3dFile(unsigned processor = intel, bool real = true, double rate_hz = 100.0)
      : processor_(processor), real_(real), rate_hz_(rate_hz) {
    reals("POINT:RATE", {rate_hz});
    texts("POINT:UNITS", {"mm"});
  }

  /// The residual is 0, or the one given for each frame.
  void point(const std::string& label, std::vector<double> x, std::vector<double> y, std::vector<double> z,
             std::vector<double> residual = {}) {
    residual.resize(x.size());
    labels_.push_back(label);
    points_.push_back({std::move(x), std::move(y), std::move(z), std::move(residual)});
    texts("POINT:LABELS", labels_);
  }
  /// Values as they stand in the file, before offset and scale: `samples` of them a frame, in every channel.
  void channel(const std::string& label, const std::string& unit, std::vector<double> raw, double gain = 1.0,
               int offset = 0, std::size_t samples = 1) {
    channel_labels_.push_back(label);
    channel_units_.push_back(unit);
    scales_.push_back(gain);
    offsets_.push_back(offset);
    channels_.push_back(std::move(raw));
    samples_ = samples;
    texts("ANALOG:LABELS", channel_labels_);
    texts("ANALOG:UNITS", channel_units_);
    reals("ANALOG:SCALE", scales_);
    integers("ANALOG:OFFSET", offsets_);
    reals("ANALOG:RATE", {rate_hz_ * static_cast<double>(samples)});
  }

  void integers(const std::string& name, const std::vector<int>& values) {
    std::string& body = parameters[name] = std::string{2, 1, static_cast<char>(values.size())};
    for (const int value : values) body += word(value);
  }
  void reals(const std::string& name, const std::vector<double>& values) {
    std::string& body = parameters[name] = std::string{4, 1, static_cast<char>(values.size())};
    for (const double value : values) body += number(value);
  }
  void texts(const std::string& name, const std::vector<std::string>& values) {
    constexpr char width = 16;
    std::string& body = parameters[name] = std::string{'\xff', 2, width, static_cast<char>(values.size())};
    for (std::string value : values) {
      value.resize(width, ' ');
      body += value;
    }
  }

  std::string word(int value) const {
    const char low = static_cast<char>(value & 0xFF), high = static_cast<char>(value >> 8 & 0xFF);
    return processor_ == mips ? std::string{high, low} : std::string{low, high};
  }
  std::string number(double value) const {
    // DEC's reals have their exponent two higher, and the word with it first; -0 has no representation.
    const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(processor_ == dec ? 4.0 * value + 0.0 : value));
    const std::string high = word(static_cast<int>(bits >> 16U)), low = word(static_cast<int>(bits & 0xFFFFU));
    return processor_ == intel ? low + high : high + low;
  }

  std::size_t frames() const {
    return points_.empty() ? channels_.front().size() / samples_ : points_.front()[0].size();
  }

  std::string bytes() const { return C3dFile(*this).write(); }

  static constexpr std::size_t block = 512;
  std::map<std::string, std::string> parameters;  ///< their types, dimensions and values
  double scale = 1.0 / 64.0;                      ///< of integer coordinates
  int first_frame = 1;

 private:
  std::string write() {
    const std::string section = parameter_section();
    const int data_block = 2 + static_cast<int>(section.size() / block);
    std::string file{2, 0x50};
    file += word(static_cast<int>(points_.size())) + word(static_cast<int>(channels_.size() * samples_)) +
            word(first_frame) + word(first_frame + static_cast<int>(frames()) - 1) + word(0) +
            number(real_ ? -scale : scale) + word(data_block) + word(static_cast<int>(samples_)) + number(rate_hz_);
    file.resize(block);
    file += section;
    for (std::size_t frame = 0; frame < frames(); ++frame) {
      for (const auto& point : points_)
        for (std::size_t k = 0; k < 4; ++k) file += value(point[k][frame], k < 3 ? scale : 1.0);
      for (std::size_t sample = 0; sample < samples_; ++sample)
        for (const std::vector<double>& channel : channels_) file += value(channel[frame * samples_ + sample], 1.0);
    }
    file.resize((file.size() + block - 1) / block * block);
    return file;
  }

  std::string value(double of, double unit) const {
    return real_ ? number(of) : word(static_cast<int>(std::lround(of / unit)));
  }

  std::string parameter_section() {
    if (!parameters.contains("POINT:SCALE")) reals("POINT:SCALE", {real_ ? -scale : scale});
    if (!parameters.contains("POINT:USED")) integers("POINT:USED", {static_cast<int>(points_.size())});
    if (!parameters.contains("ANALOG:USED")) integers("ANALOG:USED", {static_cast<int>(channels_.size())});
    if (!parameters.contains("POINT:FRAMES"))
      integers("POINT:FRAMES", {frames() < 65535 ? static_cast<int>(frames()) : 65535});
    std::string section(4, '\0');
    std::map<std::string, char> groups;
    for (const auto& [name, body] : parameters) {
      const std::size_t colon = name.find(':');
      const std::string group = name.substr(0, colon), own = name.substr(colon + 1);
      // The group stands behind its first parameter, which the format allows.
      const bool is_new = !groups.contains(group);
      const char id = groups.emplace(group, static_cast<char>(groups.size() + 1)).first->second;
      section += std::string{static_cast<char>(own.size()), id} + own + word(static_cast<int>(body.size()) + 3) + body +
                 std::string(1, '\0');
      if (is_new)
        section += std::string{static_cast<char>(-static_cast<int>(group.size())), static_cast<char>(-id)} + group +
                   word(3) + std::string(1, '\0');
    }
    section.resize((section.size() + 2 + block - 1) / block * block);
    section[2] = static_cast<char>(section.size() / block);
    section[3] = static_cast<char>(processor_);
    return section;
  }

  unsigned processor_;
  bool real_;
  double rate_hz_;
  std::vector<std::string> labels_, channel_labels_, channel_units_;
  std::vector<std::array<std::vector<double>, 4>> points_;  // x, y, z and residual
  std::vector<std::vector<double>> channels_;
  std::vector<double> scales_;
  std::vector<int> offsets_;
  std::size_t samples_ = 1;
};

}  // namespace decid::test
