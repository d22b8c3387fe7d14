// Writes data sets: see npz.hpp for the file's form.
#include <bit>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "dataset/npz/detail/npz_parts.hpp"
#include "dataset/npz/npz.hpp"
#include "sim/protocol/protocol_object.hpp"

namespace decid::dataset {

static_assert(std::endian::native == std::endian::little, "arrays are written as they are in memory");

std::string describe(const sim::Protocol& protocol, std::uint64_t seed) {
  return print_json({{"format", npz_format_version},
                     {"seed", seed},
                     {"protocol", sim::to_json_object(protocol)},
                     {"parameters", protocol.parameters().names()}});
}

void begin_array(ZipWriter& zip, const char* name, const std::string& type, const std::vector<std::size_t>& shape,
                 std::uint64_t value_bytes) {
  const std::string header = npy_header(type, shape);
  zip.begin(std::string(name) + ".npy", header.size() + value_bytes);
  zip.write(std::as_bytes(std::span(header)));
}

std::vector<std::span<const std::byte>> parameter_bytes(std::span<const sim::Parameters> parameters) {
  std::vector<std::span<const std::byte>> pieces;
  for (const sim::Parameters& of_trial : parameters) pieces.push_back(std::as_bytes(std::span(of_trial)));
  return pieces;
}

void finish_archive(ZipWriter& zip, std::span<const std::int32_t> group, std::span<const std::uint8_t> split,
                    const std::string& description) {
  begin_array<std::int32_t>(zip, "group", {group.size()});
  zip.write(std::as_bytes(group));
  zip.end();
  begin_array<std::uint8_t>(zip, "split", {split.size()});
  zip.write(std::as_bytes(split));
  zip.end();
  begin_array(zip, "decid.json", "|S" + std::to_string(description.size()), {}, description.size());
  zip.write(std::as_bytes(std::span(description)));
  zip.end();
  zip.finish();
}

std::uint64_t npz_bytes(int count, const sim::Protocol& protocol) {
  const std::uint64_t a_trial =
      protocol.parameters().size() * sizeof(double) + sizeof(std::int32_t) + sizeof(std::uint8_t);
  return static_cast<std::uint64_t>(count) * (static_cast<std::uint64_t>(protocol.samples()) * sizeof(float) + a_trial);
}

void write_npz(const std::filesystem::path& path, const Dataset& data) {
  check_dataset(data, path.string());
  const std::size_t trials = data.parameters.size();
  PendingFile pending(path);
  // The writer must seek back for the checksums, which a device does not allow.
  if (!std::filesystem::is_regular_file(pending.path())) {
    throw Error(Code::file_unwritable, path.string(), "is not a regular file, and a data set cannot be streamed",
                "give a file on a disk");
  }
  {
    DiskFile file(pending.path(), DiskFile::Access::write);
    ZipWriter zip(file);
    begin_array<float>(zip, "sway", {trials, static_cast<std::size_t>(data.samples)});
    zip.write(std::as_bytes(std::span(data.sway)));
    zip.end();
    begin_array<double>(zip, "parameters", {trials, data.protocol.parameters().size()});
    zip.write(parameter_bytes(data.parameters));
    zip.end();
    finish_archive(zip, data.group, data.split, describe(data.protocol, data.seed));
  }
  pending.commit();
}

}  // namespace decid::dataset
