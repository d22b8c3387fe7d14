// Recognises other file formats: see foreign.hpp. The first bytes come from the formats' specifications.
#include "recording/formats/detail/foreign.hpp"

#include <array>

#include "base/error.hpp"
#include "base/setting.hpp"

namespace decid::recording {

namespace {

using namespace std::string_view_literals;

constexpr std::string_view as_csv = "export the signals as CSV or as a MAT-file", unpack = "unpack it first",
                           sheet = "save the sheet as CSV";

struct Format {
  std::string_view first;  ///< its first bytes
  std::string_view is, remedy;
};

constexpr std::array formats{
    Format{"# Created by Octave"sv, "is in Octave's own format, not MATLAB's",
           "save it in Octave with save -v7 file.mat time sway"},
    Format{"Octave-1-"sv, "is in Octave's own format, not MATLAB's",
           "save it in Octave with save -v7 file.mat time sway"},
    Format{"TDSm"sv, "is a TDMS file of LabVIEW", as_csv},
    Format{"\xFF"
           "BIOSEMI"sv,
           "is a BDF file", as_csv},
    Format{"PAR1"sv, "is a Parquet file", as_csv},
    Format{"ARROW1"sv, "is an Arrow or Feather file", as_csv},
    Format{"\x93NUMPY"sv, "is a NumPy array (.npy)", "save it with numpy.savetxt, or scipy.io.savemat"},
    Format{"\x1F\x8B"sv, "is compressed with gzip", unpack},
    Format{"BZh"sv, "is compressed with bzip2", unpack},
    Format{"\xFD"
           "7zXZ"sv,
           "is compressed with xz", unpack},
    Format{"7z\xBC\xAF"sv, "is a 7-Zip archive", unpack},
    Format{"\x28\xB5\x2F\xFD"sv, "is compressed with Zstandard", unpack},
    Format{"Rar!"sv, "is a RAR archive", unpack},
    Format{"version https://git-lfs"sv, "is a pointer of Git LFS, not the file itself",
           "get the file with git lfs pull"},
    Format{"%PDF"sv, "is a PDF, not a recording", "give the recording that it shows"},
    Format{"$FL2"sv, "is a file of SPSS", as_csv},
    Format{"#ROSBAG"sv, "is a bag of ROS", "write its topic as CSV with rostopic echo -p"},
    Format{"ADInstr"sv, "is a file of LabChart (.adicht)", "export it in LabChart as text or as a MAT-file"},
    Format{"SQLite format 3"sv, "is a database of SQLite", as_csv},
    Format{"\xD0\xCF\x11\xE0"sv, "is a spreadsheet or document of Microsoft Office (.xls)", sheet},
    Format{"\x89PNG"sv, "is a picture", "give the recording itself"},
    Format{"\xFF\xD8\xFF"sv, "is a picture", "give the recording itself"},
    Format{"RIFF"sv, "is a sound or a film", "give the recording itself"},
};

bool has(std::string_view bytes, std::string_view part) {
  return bytes.substr(0, 65536).find(part) != std::string_view::npos;
}

[[noreturn]] void refuse_zip(std::string_view bytes, const std::string& where, std::string_view end) {
  const auto holds = [&](std::string_view member) { return bytes.find(member) != bytes.npos; };
  if (holds("sway.npy") && holds("parameters.npy"))
    throw Error(Code::file_unsupported, where, "is a data set, not a recording",
                "give a recording; an evaluation takes the data set as " + setting("data"));
  if (end == ".npz" || holds(".npy"))
    throw Error(
        Code::file_unsupported, where, "is an archive of NumPy arrays (.npz)",
        "save it in Python with scipy.io.savemat('file.mat', dict(numpy.load('file.npz'))), or an array of it with "
        "numpy.savetxt");
  if (has(bytes, "xl/") || end == ".xlsx")
    throw Error(Code::file_unsupported, where, "is a spreadsheet of Excel that decid does not read, or is damaged",
                std::string(sheet));
  if (has(bytes, "opendocument"))
    throw Error(Code::file_unsupported, where, "is a spreadsheet or document of OpenDocument", std::string(sheet));
  throw Error(Code::file_unsupported, where, "is a ZIP archive", std::string(unpack));
}

void refuse_markup(std::string_view text, const std::string& where) {
  const std::size_t first = text.find_first_not_of("\xEF\xBB\xBF \t\r\n");
  if (first == text.npos) return;
  text.remove_prefix(first);
  if (text.front() == '{' || text.starts_with("[{") || text.starts_with("[["))
    throw Error(Code::file_unsupported, where, "is JSON, not a table of numbers",
                "give the recording itself, a CSV, MAT, C3D or .xlsx file, instead of decid's results");
  if (text.front() != '<') return;
  if (has(text, "<mvnx"))
    throw Error(Code::file_unsupported, where, "is a recording of Xsens MVN (.mvnx)", std::string(as_csv));
  if (has(text, "<html") || has(text, "<HTML") || has(text, "<table"))
    throw Error(Code::file_unsupported, where, "is a web page (HTML)", "save the table as CSV");
  throw Error(Code::file_unsupported, where, "is XML, not a table of numbers", std::string(as_csv));
}

}  // namespace

void refuse_foreign(std::string_view bytes, const std::string& where, std::string_view end) {
  for (const Format& format : formats)
    if (bytes.starts_with(format.first))
      throw Error(Code::file_unsupported, where, std::string(format.is), std::string(format.remedy));
  if (bytes.starts_with("PK\x03\x04")) refuse_zip(bytes, where, end);
  if (bytes.starts_with("0       ") && bytes.size() > 256 && bytes[170] == '.' && bytes[173] == '.')  // its date
    throw Error(Code::file_unsupported, where, "is an EDF file", std::string(as_csv));
  if (end == ".acq" && bytes.find('\0') != bytes.npos)
    throw Error(Code::file_unsupported, where, "is a file of AcqKnowledge (.acq)",
                "export it in AcqKnowledge as text or as a MAT-file");
  refuse_markup(bytes, where);
}

}  // namespace decid::recording
