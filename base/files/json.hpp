// The type of JSON values, declared only; json_object.hpp reads and prints them.
// Not installed.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace decid {

/// The library's own type under a name of decid's, so that Json differs from every other library's type.
template <class T, class = void>
struct JsonSerializer : nlohmann::adl_serializer<T, void> {};

/// Keeps the keys in written order. Nested no deeper than deepest_json (json_object.hpp).
using Json = nlohmann::basic_json<nlohmann::ordered_map, std::vector, std::string, bool, std::int64_t, std::uint64_t,
                                  double, std::allocator, JsonSerializer>;

}  // namespace decid
