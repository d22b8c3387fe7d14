// Refuses MAT-files of version 7.3 in a build without HDF5: a web page (bindings/web).
#include "base/error.hpp"
#include "recording/formats/detail/mat/mat_73.hpp"

namespace decid::recording {

std::vector<MatVariable> read_mat_73(const std::filesystem::path& path, std::size_t) {
  throw Error(Code::not_supported, path.string(),
              "is a MAT-file of version 7.3, which this build of decid does not read",
              "save it in MATLAB with save('file.mat', 'time', 'sway', '-v7'), or as CSV");
}

}  // namespace decid::recording
