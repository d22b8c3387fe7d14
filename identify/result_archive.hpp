// The members of a RecordingResult, for base/archive.hpp: what ranks send and journals keep. Not installed.
#pragma once

#include "base/archive.hpp"
#include "identify/result.hpp"

namespace decid {

template <class Archive>
void archive(Archive& a, Warning& w) {
  a(w.severity, w.code, w.text);
}
template <class Archive>
void archive(Archive& a, recording::TiltMatch& tilt) {
  a(tilt.delay_s, tilt.correlation, tilt.gain, tilt.moved_before, tilt.is_other_size);
}
template <class Archive>
void archive(Archive& a, recording::LowPass& filter) {
  a(filter.order, filter.both_ways, filter.cutoff_hz, filter.rate_hz, filter.gain_low, filter.gain_high,
    filter.averaged);
}
template <class Archive>
void archive(Archive& a, recording::Trial& trial) {
  a(trial.signals, trial.tilt, trial.tilt_at_given_start, trial.is_large, trial.gaps, trial.low_pass);
}
template <class Archive>
void archive(Archive& a, Estimate& estimate) {
  a(estimate.parameters, estimate.distribution, estimate.image, estimate.distance, estimate.warnings);
}
template <class Archive>
void archive(Archive& a, sim::FrfPoint& point) {
  a(point.frequency_hz, point.harmonics, point.response, point.radius, point.coherence);
}
template <class Archive>
void archive(Archive& a, FrequencyResponses& frf) {
  a(frf.cycles, frf.recorded, frf.model, frf.linear);
}
template <class Archive>
void archive(Archive& a, Explanation& e) {
  a(e.fitted_rad, e.rms_residual_deg, e.variance_accounted_for, e.response_ratio, e.response_ratio_mean,
    e.response_ratio_sd, e.gain, e.ood_score, e.unlike_training, e.frf, e.warnings);
}
template <class Archive>
void archive(Archive& a, posterior::State& state) {
  a(state.parameters, state.sensor_noise_deg, state.start_s, state.gain, state.slow_noise_deg, state.slow_memory_s);
}
template <class Archive>
void archive(Archive& a, posterior::Band& band) {
  a(band.low, band.middle, band.high);
}
template <class Archive>
void archive(Archive& a, posterior::Inferred& inferred) {
  posterior::LeaveOneOut& left_out = inferred.left_out;
  a(inferred.sway_rad, inferred.noise_rad_s, inferred.tilt_estimate_rad, left_out.log_density, left_out.standard_error,
    left_out.effective_parameters, left_out.max_shape, left_out.unreliable, inferred.recorded_blocks,
    inferred.log_likelihood);
}
template <class Archive>
void archive(Archive& a, CheckedFigure& figure) {
  a(figure.name, figure.in_degrees, figure.recorded, figure.low, figure.middle, figure.high, figure.p);
}
template <class Archive>
void archive(Archive& a, CheckedResponses& responses) {
  a(responses.recorded, responses.gain, responses.phase_rad);
}
template <class Archive>
void archive(Archive& a, PredictiveCheck& check) {
  a(check.standing, check.figures, check.sway_rad, check.responses);
}
template <class Archive>
void archive(Archive& a, ControllerFit& fit) {
  a(fit.controller, fit.posterior, fit.sway_rad, fit.check, fit.compared, fit.warnings, fit.comparable);
}
template <class Archive>
void archive(Archive& a, JointFit& fit) {
  a(fit.files, fit.freed, fit.condition);
}
template <class Archive>
void archive(Archive& a, FitFigures& fit) {
  a(fit.answer, fit.posterior, fit.network, fit.inferred, fit.stored_draws, fit.check, fit.samples_noise_deg,
    fit.block_s, fit.edge_s, fit.first_edge_s, fit.seconds, fit.stopped, fit.compared, fit.others, fit.comparable,
    fit.joint);
}
template <class Archive>
void archive(Archive& a, RecordingResult& result) {
  a(result.file, result.error, result.column, result.tilt_column, result.truth, result.trial, result.estimate,
    result.explanation, result.fit, result.warnings);
}

}  // namespace decid
