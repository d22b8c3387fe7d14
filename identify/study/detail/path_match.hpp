// Finds the recording that a cell of a sheet names, and the recordings of a person. Letter case, accents in NFC or NFD,
// the direction of slashes and the ending of the name do not count. Not installed.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace decid {

/// A path as parts for comparison.
class PathKey {
 public:
  explicit PathKey(const std::string& path);

  /// The likeness of two names: not at all; without their endings, such as .csv and .tsv; with them; letter by letter.
  enum class Likeness { none, without_ending, forgiving, exact };
  /// Compares the last parts of this path with all parts of `end`: "a/trial.csv" with "trial.csv".
  Likeness ends_with(const PathKey& end) const;
  /// Returns the number of parts.
  std::size_t parts() const { return exact_.size(); }

  /// The clarity of a name in a path: not there; within a part, or a file's whole name; a folder; after "sub-" or
  /// "ses-".
  enum class Naming { none, within, folder, prefixed };
  /// Finds a participant in the parts of the path, alone or within other text: "sub-01" or "01" names
  /// "data/sub-01/ses-1/trial.csv", "P1" names "P1_closed.csv" but not "P10.csv". Numbers need "sub-" or a folder.
  Naming naming_of_participant(const std::string& participant) const { return naming_of(participant, "sub-", parts()); }
  /// The same for a participant's session. A part that is the participant's whole name names no session: in "1/2.csv"
  /// the session is 2.
  Naming naming_of_session(const std::string& session, const std::string& participant) const;
  /// Returns the different LABELs of "ses-LABEL" (BIDS 1.9, entities): of folders below a "sub-" one, and between
  /// underscores in the file's name. Letter case does not count.
  std::vector<std::string> session_labels() const;

 private:
  Naming naming_of(const std::string& wanted, const std::string& prefix, std::size_t except) const;
  /// Returns a part; the file's without its ending.
  const std::string& part(std::size_t i) const;

  std::vector<std::string> exact_, forgiving_;  // parts
  std::string stem_;                            // the last part of forgiving_ without its ending
};

}  // namespace decid
