// C3D files of motion capture as tables. The format is that of c3d.org's manual.
// Not installed.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "recording/formats/c3d_parameters.hpp"
#include "recording/table/table.hpp"

namespace decid::recording {

/// Returns true for the first bytes of a C3D file. `end`: the file's extension in lower case.
bool is_c3d(std::string_view bytes, std::string_view end);

/// Three columns a point, "LASI_x (mm)", "LASI_y (mm)", "LASI_z (mm)", in the laboratory's axes, then one an analog
/// channel, "Tilt (deg)". Units are the file's: POINT:UNITS, or ANGLE_UNITS and the like for what POINT:ANGLES and the
/// like list, and ANALOG:UNITS. A subject's name before the labels ("Ann:LASI") is left out if all that have one have
/// the same. What has no label is called by its number: "point 3_x", "analog 2". A row is a frame: analog channels that
/// are sampled faster are brought to the points' rate by a low-pass without delay (resample.hpp). In a file without
/// points a row is an analog sample. A negative residual is a missing value (NaN). No column is taken for the time.
/// Counts of 65,535 frames, as far as 16 bits go, stand for all that are stored; where other counts leave out frames, a
/// caution says so.
class C3dTable final : public Table {
 public:
  /// bytes: the whole file. Throws Error for bytes that are not of a C3D file or end too early, counts that contradict
  /// each other, more than 10 million rows or 10,000 columns, and a file without points and analog channels.
  C3dTable(std::string bytes, std::string where);

  std::size_t rows(int) const override { return rows_; }
  bool has_header() const override { return true; }
  const std::vector<std::string>& names() const override { return names_; }
  std::vector<double> numbers(int column, Missing missing) const override;
  std::string place_of(std::size_t row) const override;
  const std::vector<StatedRate>& stated_rates() const override { return rates_; }
  bool is_even() const override { return true; }
  std::string change_of(int column) const override;
  const Warnings& warnings() const override { return warnings_; }
  std::string format_of_one() const override { return "C3D file"; }

 private:
  void read_layout(const C3dParameters& parameters);
  std::size_t count_frames(const C3dParameters& parameters, std::size_t data_bytes) const;
  /// Frames behind the last one that is counted, but for the padding of a block.
  void look_for_more_frames(std::size_t data_bytes);
  void name_points(const C3dParameters& parameters);
  void name_channels(const C3dParameters& parameters);
  void read_rates(const C3dParameters& parameters);
  bool is_faster(int column) const;
  std::size_t value_bytes() const { return is_real_ ? 4 : 2; }
  std::size_t frame_bytes() const { return (4 * points_ + channels_ * samples_) * value_bytes(); }
  std::vector<double> coordinates(std::size_t point, std::size_t axis) const;
  std::vector<double> samples(std::size_t channel) const;

  std::string bytes_, where_;
  C3dBytes file_;
  bool is_real_ = false, is_unsigned_ = false;
  std::size_t points_ = 0, channels_ = 0;
  std::size_t samples_ = 1;  ///< of a channel in a frame
  std::size_t data_ = 0;     ///< the first frame's first byte
  std::size_t frames_ = 0, rows_ = 0, first_frame_ = 1;
  double scale_ = 1.0;                   ///< of integer coordinates
  std::vector<double> gains_, offsets_;  ///< of the channels
  std::vector<std::string> names_;
  std::vector<StatedRate> rates_;
  Warnings warnings_;
};

}  // namespace decid::recording
