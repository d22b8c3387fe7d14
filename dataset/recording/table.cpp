// Which kind of file a table is read from: see table.hpp.
#include "dataset/recording/table.hpp"

#include <algorithm>
#include <cctype>

#include "base/error.hpp"
#include "base/file.hpp"
#include "dataset/recording/csv.hpp"
#include "dataset/recording/mat.hpp"

namespace decid::dataset {

namespace {

constexpr std::size_t file_limit_bytes = std::size_t{1} << 30;

}  // namespace

const char* remedy_for(Missing missing) {
  return missing == Missing::fillable
             ? "give a value; short gaps of a recording are interpolated with --fill-gaps SECONDS"
             : "give a value";
}

std::unique_ptr<Table> read_table(const std::filesystem::path& path) {
  std::string end = path.extension().string();
  std::transform(end.begin(), end.end(), end.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  // Reading it first gives the reason if a file cannot be read or is too large.
  std::string text = read_file(path, file_limit_bytes);
  if (end == ".mat" || text.starts_with("MATLAB ")) {
    check_mat(text, path.string());
    text = {};
    return std::make_unique<MatTable>(path);
  }
  if (const std::size_t first = text.find_first_not_of(" \t\r\n"); first != text.npos && text[first] == '{') {
    throw Error(path.string(), "is JSON, not a table of numbers",
                "give the recording itself, a CSV or MAT-file; results of decid are none");
  }
  return std::make_unique<CsvTable>(std::move(text), path.string());
}

}  // namespace decid::dataset
