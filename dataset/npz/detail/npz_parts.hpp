// Shared parts of the two writers of .npz files: writing arrays in order, and the text that describes them. Private to
// npz_write.cpp and npz_generate.cpp.
#pragma once

#include <concepts>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "dataset/npz/detail/npy.hpp"
#include "dataset/npz/detail/zip.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::dataset {

/// Returns the content of decid.json, see npz.hpp.
std::string describe(const sim::Protocol& protocol, std::uint64_t seed);

/// Returns the NumPy type of values of type T.
template <class T>
constexpr const char* npy_type() {
  if constexpr (std::same_as<T, float>) return "<f4";
  if constexpr (std::same_as<T, double>) return "<f8";
  if constexpr (std::same_as<T, std::int32_t>) return "<i4";
  if constexpr (std::same_as<T, std::uint8_t>) return "|u1";
}

/// Begins the member of an array; its values follow by write and skip.
void begin_array(ZipWriter& zip, const char* name, const std::string& type, const std::vector<std::size_t>& shape,
                 std::uint64_t value_bytes);
template <class T>
void begin_array(ZipWriter& zip, const char* name, const std::vector<std::size_t>& shape) {
  begin_array(zip, name, npy_type<T>(), shape, value_count(shape) * sizeof(T));
}

/// Returns the bytes of each set of parameters.
std::vector<std::span<const std::byte>> parameter_bytes(std::span<const sim::Parameters> parameters);

/// Writes the arrays after sway and parameters, and ends the archive.
void finish_archive(ZipWriter& zip, std::span<const std::int32_t> group, std::span<const std::uint8_t> split,
                    const std::string& description);

}  // namespace decid::dataset
