// The people of a sheet: finds the line that a person's recordings share, by the recordings' paths, and the bodies for
// lines that give none, as often only a person's first line does. Not installed.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/warning.hpp"
#include "identify/study/detail/path_match.hpp"
#include "identify/study/sheet.hpp"

namespace decid {

/// The lines of people that a recording's path fits, by their places in the sheet.
struct FittingLines {
  std::optional<std::size_t> line;   ///< the recording's; none if the path fits no line, or several equally well
  std::vector<std::size_t> fitting;  ///< all of the recording's person; without `line` two of other people or sessions
  std::vector<std::size_t> elsewhere = {};  ///< without any of these: the person's lines, whose sessions the path lacks
};

/// The participants and sessions of a sheet's lines, as text_key() compares them.
class PersonLines {
 public:
  PersonLines() = default;
  explicit PersonLines(const std::vector<SheetLine>& lines);

  /// Finds the line without a file whose participant and session the path names. The participant with the clearest name
  /// comes first, then the line with the clearest session, then lines without a session.
  FittingLines find(const PathKey& path) const;
  /// Returns true if the line `person` is of all recordings of a person, among them those of the line `recording`.
  bool covers(std::size_t person, std::size_t recording) const;
  /// Returns true if another line has a file of this line's participant.
  bool has_recording_line(std::size_t person) const;

 private:
  struct Line {
    std::string participant, session;
    bool is_recording;
  };
  /// Returns two of the lines whose texts differ; none if all are alike.
  std::vector<std::size_t> find_unlike(const std::vector<std::size_t>& some, std::string Line::*text) const;

  std::vector<Line> lines_;
};

/// The weights and heights that the lines of a sheet give, by their people.
class PersonBodies {
 public:
  PersonBodies() = default;
  explicit PersonBodies(const std::vector<SheetLine>& lines);

  /// Fills the weight and the height that a line lacks from other lines of its person: from those of the same session
  /// first, then from lines above before lines below, from the nearest. Then returns the note `body_of_other_line`;
  /// else nothing.
  Warnings fill(SheetLine& line) const;

 private:
  struct Giver {
    std::size_t number;
    std::string session;
    std::optional<double> mass_kg, height_m;
  };
  static const Giver* find(const std::vector<Giver>& givers, const SheetLine& line,
                           std::optional<double> Giver::*quantity);

  std::map<std::string, std::vector<Giver>> givers_;  // by text_key() of the participant
};

}  // namespace decid
