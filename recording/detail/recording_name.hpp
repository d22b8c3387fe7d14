// Names and remedies in messages about a recording, which is a file or samples in memory. Not installed.
#pragma once

#include <string>

#include "recording/recording.hpp"

namespace decid::recording {

inline bool in_memory(const Recording& recording) {
  return recording.file.empty();
}

/// Returns the recording's name in errors.
inline std::string where(const Recording& recording) {
  return in_memory(recording) ? "recording" : recording.file;
}

/// Returns the remedy for samples in memory, or for samples of files, which options read.
inline std::string either(const Recording& recording, const std::string& for_samples, const std::string& for_files) {
  return in_memory(recording) ? for_samples : for_files;
}

}  // namespace decid::recording
