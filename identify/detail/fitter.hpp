// Shared parts of fits of one recording and of several together: see fit_recordings.hpp. Not installed.
#pragma once

#include <utility>

#include "base/error.hpp"
#include "identify/fit_recordings.hpp"

namespace decid {

/// Returns an error of a recording, with its file.
inline Error in_file(const Error& error, const std::string& file) {
  return Error(error.code(), file + ", " + error.where(), error.problem(), error.remedy());
}

/// Runs a task of a recording, which gets the task's error.
template <class Task>
void attempt(RecordingResult& result, const Task& task) {
  try {
    task();
  } catch (const Error& error) {
    result.error = in_file(error, result.file);
  }
}

/// Returns the progress of a run; sets `cut` when it stops the run.
inline posterior::OnProgress noting_stop(posterior::OnProgress progress, bool& cut) {
  return [progress = std::move(progress), &cut](const posterior::Progress& here) {
    cut = cut || (progress && !progress(here));
    return !cut;
  };
}

/// Returns true for a run that was stopped with draws left: a stop after the last draws takes nothing away.
inline bool is_incomplete(const posterior::Posterior& drawn, bool cut, const posterior::Settings& settings) {
  return cut && drawn.draws_per_chain() < settings.max_draws;
}

/// A recording in the form that its density needs.
struct Fitter::Prepared {
  recording::Trial trial;  ///< before a low-pass
  bool moved;
  const posterior::Density* density;
  posterior::Observation observation;
};

}  // namespace decid
