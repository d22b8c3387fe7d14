// C3D files of motion capture as tables. Format: the manual of c3d.org.
// Not installed.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "recording/formats/detail/c3d_parameters.hpp"
#include "recording/table/table.hpp"

namespace decid::recording {

/// Returns true for the first bytes of a C3D file. `end`: the file's extension in lower case.
bool is_c3d(std::string_view bytes, std::string_view end);

/// A C3D file as a table. Each point has three columns, "LASI_x (mm)", "LASI_y (mm)" and "LASI_z (mm)", in the
/// laboratory's axes; one column per analog channel follows, "Tilt (deg)".
/// - Units are the file's: POINT:UNITS or ANALOG:UNITS. Labels that POINT:ANGLES and similar parameters list have
/// ANGLE_UNITS and so on.
/// - A subject's name before the labels ("Ann:LASI") is removed if all labels with a subject have the same one.
/// - Columns without a label are named by their number: "point 3_x", "analog 2".
/// - A row is a frame. Analog channels sampled faster are resampled to the points' rate without delay (resample.hpp).
/// In a file without points a row is an analog sample.
/// - A negative residual is a missing value (NaN). No column is the time.
/// - A count of 65,535 frames, the most that 16 bits hold, stands for all stored frames. If other counts leave out
/// frames, the table has a caution.
class C3dTable final : public Table {
 public:
  /// Reads a file from all of its bytes. Throws Error for bytes that are not a C3D file or end too early, and for
  /// contradicting counts. Throws Error for more than 10 million rows or 10,000 columns, and for a file without points
  /// and analog channels.
  C3dTable(std::string bytes, std::string where);

  std::size_t rows(int) const override { return rows_; }
  bool has_header() const override { return true; }
  const std::vector<std::string>& names() const override { return names_; }
  std::vector<double> numbers(int column, Missing missing) const override;
  std::string locate(std::size_t row) const override;
  const std::vector<StatedRate>& stated_rates() const override { return rates_; }
  bool is_even() const override { return true; }
  std::string change_at(int column) const override;
  const Warnings& warnings() const override { return warnings_; }
  std::string format_of_one() const override { return "C3D file"; }

 private:
  void read_layout(const C3dParameters& parameters);
  std::size_t count_frames(const C3dParameters& parameters, std::size_t data_bytes) const;
  /// Looks for frames after the last one counted, apart from the padding of a block.
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
  std::size_t samples_ = 1;  ///< per channel and frame
  std::size_t data_ = 0;     ///< offset of the first frame
  std::size_t frames_ = 0, rows_ = 0, first_frame_ = 1;
  double scale_ = 1.0;                   ///< of integer coordinates
  std::vector<double> gains_, offsets_;  ///< per channel
  std::vector<std::string> names_;
  std::vector<StatedRate> rates_;
  Warnings warnings_;
};

}  // namespace decid::recording
