// Posteriors of recordings at a protocol's rate and length: samples, checks and explains them. A recording that cannot
// be used does not stop the others.
//
//   Fitter fitter(&model, protocol, body, request);
//   Report report = fitter.report();
//   report.recordings = read_recordings(protocol, sources, options);
//   fitter.fit(report.recordings);
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>

#include "identify/recordings.hpp"

namespace decid {

/// Reports progress: the recording, counted from 0, and its sampling. Returns false to stop. One thread at a time calls
/// it; several recordings are fitted at the same time.
using FitProgress = std::function<bool(std::size_t recording, const posterior::Progress& progress)>;

/// Receives each recording that was begun, when it is done or has an error. One thread at a time calls it. It may move
/// this recording's result, but must not touch the others, which are still being written.
using OnFitted = std::function<void(std::size_t recording)>;

/// Recordings of one person that are fitted together. All their parameters are the same, except FitRequest::freed,
/// which are the same in recordings of one condition.
struct FitGroup {
  std::vector<std::size_t> recordings;
  std::vector<std::string> conditions{};  ///< of each recording; empty: one condition
};

/// Returns the groups, and recordings of no group as groups of one, in the order of their first recordings.
std::vector<FitGroup> with_singletons(std::vector<FitGroup> groups, std::size_t recordings);

/// Fits recordings of one protocol: has the tables that the fits share. The model must outlive it.
class Fitter {
 public:
  /// model: its network supplies estimates if it covers the experiment; may be null. body: the person's or robot's;
  /// empty: the protocol's. Throws Error if the protocol cannot be fitted, or the request frees and fixes a parameter.
  Fitter(const Model* model, sim::Protocol protocol, const std::optional<sim::Body>& body, FitRequest request);
  Fitter(const Fitter&) = delete;
  Fitter& operator=(const Fitter&) = delete;
  ~Fitter();

  /// Returns the common values of the recordings, without any recording.
  const Report& report() const noexcept { return report_; }

  /// Samples the posterior of each recording without an error, in their order, and checks whether its draws predict the
  /// recording; if they do not, its first warning says so. If chains are far apart, a warning says so, and the estimate
  /// is the network's. A run that is stopped keeps what was drawn until then, begins no other recording, and returns
  /// false. The results do not depend on the number of threads. An error of one recording does not affect the others.
  bool fit(std::span<RecordingResult> read, const FitProgress& progress = {}, const OnFitted& fitted = {});

 private:
  friend bool fit_each(std::span<RecordingResult> read, const std::function<Fitter&(std::size_t recording)>& fitter_of,
                       const FitProgress& progress, const OnFitted& fitted, std::span<const FitGroup> groups);
  class Plan;
  struct Prepared;
  struct NetworkAnswer;
  struct Member;
  using FitterOf = std::function<Fitter&(std::size_t recording)>;
  void fit(RecordingResult& result, const Prepared& prepared, const posterior::OnProgress& progress);
  /// Fits the recordings of a group that have no error. One that reading has found not usable, whose platform tilted by
  /// another size, or that hardly follows the tilt and is not usable by a fit of its own, is fitted alone. An error of
  /// one does not affect the others.
  static void fit_together(std::span<RecordingResult> read, const FitterOf& fitter_of, const FitGroup& group,
                           const posterior::OnProgress& progress);
  /// Throws Error if the recordings cannot be fitted together.
  static void fit_jointly(std::deque<Member>& members, const posterior::OnProgress& progress);
  bool is_left_out(RecordingResult& one, const posterior::OnProgress& progress);
  Prepared prepare(RecordingResult& result);
  /// Compares the draws with the network's answer, which replaces the estimate if the chains disagree.
  NetworkAnswer ask_network(RecordingResult& result);
  /// Explains and checks a recording by its posterior.
  void conclude(RecordingResult& result, const Prepared& prepared, posterior::Posterior found);
  /// Fits the request's other controllers and compares them; leaves them out if it is stopped.
  void fit_others(RecordingResult& result, const Prepared& prepared, const posterior::OnProgress& progress);
  /// Returns the progress of one of a recording's fits, `fitted` of which are over.
  posterior::OnProgress part_progress(const posterior::OnProgress& progress, std::size_t fitted) const;

  Report report_;
  std::unique_ptr<Plan> plan_;
};

/// Does the same as Fitter::fit() with a fitter of its own for each recording; recordings may share one. groups: of
/// recordings that are fitted together, by their places; each recording is in at most one, and is fitted alone if it is
/// in none. If a group cannot be fitted together, each of its recordings has the error.
bool fit_each(std::span<RecordingResult> read, const std::function<Fitter&(std::size_t recording)>& fitter_of,
              const FitProgress& progress = {}, const OnFitted& fitted = {}, std::span<const FitGroup> groups = {});

}  // namespace decid
