// Arrays as .npz: see arrays.hpp.
#include "dataset/npz/arrays.hpp"

#include "base/error.hpp"
#include "base/file.hpp"
#include "dataset/npz/npz_parts.hpp"

namespace decid::dataset {

void write_arrays(const std::filesystem::path& path, std::span<const NamedArray> arrays) {
  for (const NamedArray& array : arrays) {
    if (value_count(array.shape) != array.values.size())
      throw Error(path.string(), "array " + array.name + " has " + std::to_string(array.values.size()) + " values",
                  "give it the shape of so many");
  }
  PendingFile pending(path);
  // A device is written to directly, and the writer could not go back in it for the checksums.
  if (!std::filesystem::is_regular_file(pending.path()))
    throw Error(path.string(), "is not a regular file, and arrays cannot be streamed", "name a file on a disk");
  {
    DiskFile file(pending.path(), DiskFile::Access::write);
    ZipWriter zip(file);
    for (const NamedArray& array : arrays) {
      begin_array<double>(zip, array.name.c_str(), array.shape);
      zip.write(std::as_bytes(array.values));
      zip.end();
    }
    zip.finish();
  }
  pending.commit();
}

}  // namespace decid::dataset
