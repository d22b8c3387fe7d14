// Arrays as .npz: see arrays.hpp.
#include "dataset/npz/arrays.hpp"

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "dataset/npz/detail/npz_parts.hpp"

namespace decid::dataset {

struct ArrayWriter::Parts {
  explicit Parts(const std::filesystem::path& path) : pending(path), file(regular(path), DiskFile::Access::write) {}

  PendingFile pending;
  DiskFile file;
  ZipWriter zip{file};
  bool begun = false;

 private:
  // The writer must seek back for the checksums, which a device does not allow.
  const std::filesystem::path& regular(const std::filesystem::path& path) const {
    if (!std::filesystem::is_regular_file(pending.path()))
      throw Error(Code::file_unwritable, path.string(), "is not a regular file, and arrays cannot be streamed",
                  "give a file on a disk");
    return pending.path();
  }
};

ArrayWriter::ArrayWriter(const std::filesystem::path& path) : parts_(std::make_unique<Parts>(path)) {}
ArrayWriter::~ArrayWriter() = default;

template <class Value>
void ArrayWriter::begin(const std::string& name, const std::vector<std::size_t>& shape) {
  end();
  begin_array<Value>(parts_->zip, name.c_str(), shape);
  parts_->begun = true;
}
template void ArrayWriter::begin<float>(const std::string&, const std::vector<std::size_t>&);
template void ArrayWriter::begin<double>(const std::string&, const std::vector<std::size_t>&);
template void ArrayWriter::begin<std::uint8_t>(const std::string&, const std::vector<std::size_t>&);

void ArrayWriter::write_bytes(std::span<const std::byte> bytes) {
  parts_->zip.write(bytes);
}

void ArrayWriter::add_text(const std::string& name, const std::string& text) {
  end();
  begin_array(parts_->zip, name.c_str(), "|S" + std::to_string(text.size()), {}, text.size());
  parts_->begun = true;
  write_bytes(std::as_bytes(std::span(text)));
}

void ArrayWriter::end() {
  if (parts_->begun) parts_->zip.end();
  parts_->begun = false;
}

void ArrayWriter::commit() {
  end();
  parts_->zip.finish();
  parts_->pending.commit();
}

void write_arrays(const std::filesystem::path& path, std::span<const NamedArray> arrays) {
  for (const NamedArray& array : arrays) {
    if (value_count(array.shape) != array.values.size())
      throw Error(Code::size_mismatch, path.string(),
                  "array " + array.name + " has " + std::to_string(array.values.size()) + " values",
                  "give it a shape of this size");
  }
  ArrayWriter writer(path);
  for (const NamedArray& array : arrays) {
    writer.begin<double>(array.name, array.shape);
    writer.write(array.values);
  }
  writer.commit();
}

}  // namespace decid::dataset
