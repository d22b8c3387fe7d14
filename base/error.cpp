// The library's error type: see error.hpp.
#include "base/error.hpp"

#include <cerrno>
#include <cstddef>
#include <iterator>
#include <utility>

namespace decid {
namespace {

constexpr const char* code_names[] = {"file_missing",
                                      "file_unreadable",
                                      "file_unwritable",
                                      "file_damaged",
                                      "file_unsupported",
                                      "file_too_large",
                                      "file_empty",
                                      "file_in_use",
                                      "file_exists",
                                      "file_differs",
                                      "setting_out_of_range",
                                      "setting_unknown",
                                      "setting_malformed",
                                      "setting_missing",
                                      "setting_conflict",
                                      "column_missing",
                                      "column_ambiguous",
                                      "column_unsuitable",
                                      "table_unclear",
                                      "unit_unknown",
                                      "rate_unknown",
                                      "times_uneven",
                                      "value_missing",
                                      "value_invalid",
                                      "recording_ambiguous",
                                      "recording_too_short",
                                      "protocol_mismatch",
                                      "trials_missing",
                                      "data_reused",
                                      "body_falls",
                                      "diverged",
                                      "size_mismatch",
                                      "not_supported",
                                      "system_failed",
                                      "out_of_memory",
                                      "stopped",
                                      "recordings_failed",
                                      "internal"};
static_assert(std::size(code_names) == static_cast<std::size_t>(Code::internal) + 1);

}  // namespace

const char* name(Code code) {
  return code_names[static_cast<std::size_t>(code)];
}

Code opening_failed(int error) {
  return error == ENOENT || error == ENOTDIR ? Code::file_missing : Code::file_unreadable;
}

Error::Error(Code code, std::string where, std::string problem, std::string remedy)
    : std::runtime_error(where + ": " + problem + "; " + remedy),
      code_(code),
      where_(std::move(where)),
      problem_(std::move(problem)),
      remedy_(std::move(remedy)) {}

WriteError::WriteError(std::string where, std::string problem, std::string remedy)
    : Error(Code::file_unwritable, std::move(where), std::move(problem), std::move(remedy)) {}

}  // namespace decid
