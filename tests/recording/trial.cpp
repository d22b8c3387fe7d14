// Recordings brought to a protocol: longer and shorter ones, offset and drift, and the measured tilt as a clock.
#include "recording/trial.hpp"

#include <cmath>
#include <optional>

#include "base/math/random.hpp"
#include "recording/detail/tilt/tilt_match.hpp"
#include "recording/recording.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"
#include "tests/sim/tiny_protocol.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

/// Two cycles of 4 s after 1 s of rest, 900 samples at 100 Hz.
sim::Protocol two_cycles() {
  sim::Protocol protocol = tiny_protocol();
  protocol.sequence().cycles = 2;
  protocol.sequence().lead_in_s = 1.0;
  return protocol;
}

/// Sample k is k / 1000 rad, which no filter changes.
Recording ramp(std::size_t samples, double rate_hz = 100.0) {
  Recording recording;
  recording.file = "r.csv";
  recording.rate_hz = rate_hz;
  std::vector<double>& sway = recording.signals.add({com_sway, "sway", {}}).rad;
  for (std::size_t k = 0; k < samples; ++k) sway.push_back(static_cast<double>(k) / 1000.0);
  return recording;
}

/// The protocol's tilt at t seconds; held before and after the trial.
double tilt_at(const sim::Stimulus& stimulus, const sim::Protocol& protocol, double t) {
  const double step = std::min(std::max(t * 1000.0, 0.0), static_cast<double>(protocol.experiment.steps() - 1));
  const int below = static_cast<int>(step);
  return stimulus.tilt_at(below) + (step - below) * stimulus.rate_at(below) / 1000.0;
}

/// `seconds` of a recording in which the protocol starts after delay_s; the sway is the time since then, in mrad.
Recording with_tilt(const sim::Protocol& protocol, double delay_s, double seconds, double rate_hz, double factor = 1.0,
                    double noise_rad = 0.0) {
  const sim::Stimulus stimulus = sim::make_stimulus(protocol.experiment);
  const Random random(2, sim::streams::sensor_noise, 0);
  Recording recording = ramp(0, rate_hz);
  recording.signals.add({platform_tilt, "platform", {}});
  for (std::size_t k = 0; k < static_cast<std::size_t>(seconds * rate_hz); ++k) {
    const double t = static_cast<double>(k) / rate_hz - delay_s;
    recording.signals.at(com_sway).rad.push_back(t / 1000.0);
    recording.signals.at(platform_tilt)
        .rad.push_back(0.02 + factor * tilt_at(stimulus, protocol, t) + noise_rad * random.normal(k));
  }
  return recording;
}

double mean(const std::vector<float>& values, std::size_t begin, std::size_t end) {
  double sum = 0.0;
  for (std::size_t k = begin; k < end; ++k) sum += static_cast<double>(values[k]);
  return sum / static_cast<double>(end - begin);
}

}  // namespace

TEST_CASE("a longer recording is cut from the option's start, and the cut is reported") {
  const sim::Protocol protocol = two_cycles();
  Recording recording = ramp(1250);
  const std::vector<float> first = bring_to_protocol(recording, protocol).sway_rad();
  REQUIRE(first.size() == 900);
  CHECK(first[0] == 0.0F);
  CHECK(first[899] == static_cast<float>(0.899));
  CHECK(warns(recording, "lasts 12.5 s, the protocol 'tiny' 9 s: the last 3.5 s are not used; begin"));
  recording.warnings.clear();
  CHECK(bring_to_protocol(recording, protocol, {.start_s = 2.0}).sway_rad()[0] == static_cast<float>(0.2));
  CHECK(warns(recording, "the first 2 s and the last 1.5 s are not used"));
  CHECK_FALSE(warns(recording, "begin"));
  recording.warnings.clear();
  bring_to_protocol(recording, protocol, {.start_s = 3.5});
  CHECK(warns(recording, "the first 3.5 s are not used"));
  for (const double start : {-0.1, 12.5, std::nan("")}) {
    check_error([&] { bring_to_protocol(recording, protocol, {.start_s = start}); }, Code::setting_out_of_range,
                "12.5 s");
  }
  check_error([&] { bring_to_protocol(recording, protocol, {.start_s = 4.0}); }, Code::recording_too_short, "8.5 s");
  // One cycle and the rest before it take 5 s.
  Recording shorter = ramp(850);
  check_error([&] { bring_to_protocol(shorter, protocol); }, Code::recording_too_short, "the other 3.5 s");
  Recording one = ramp(500);
  CHECK_FALSE(contains(error_of([&] { bring_to_protocol(one, protocol); }).what(), "the other"));
  // At another rate the start need not be a sample's time. Away from the ends, which are held.
  Recording slow = ramp(1000, 80.0);
  const std::vector<float> moved = bring_to_protocol(slow, protocol, {.start_s = 1.003}).sway_rad();
  for (std::size_t k = 0; k < 900; k += 90) {
    const double exact = (1.003 + static_cast<double>(k) / 100.0) * 80.0 / 1000.0;
    // A straight line comes through to 1e-3 of a sample's step, here of 1 mrad, and is rounded to float.
    CHECK(within(moved[k], exact, 1.1e-6));
  }
}

TEST_CASE("faults of the samples count where they are used, and from the recording's start") {
  const sim::Protocol protocol = two_cycles();
  const Random random(3, sim::streams::sensor_noise, 0);
  Recording whole = ramp(0);
  for (std::size_t k = 0; k < 3000; ++k) {
    const bool at_rest = k < 1000 || k >= 2900, is_held = k >= 1500 && k < 1530;
    whole.signals.at(com_sway).rad.push_back(0.01 * std::sin(0.02 * static_cast<double>(k)) + 2e-4 * random.normal(k));
    if (at_rest || is_held) whole.signals.at(com_sway).rad[k] = at_rest ? 0.003 : whole.signals.at(com_sway).rad[1499];
  }
  const auto is_frozen = [&](double start_s, const char* text) {
    Recording recording = whole;
    bring_to_protocol(recording, protocol, {.start_s = start_s});
    return warns(recording, text);
  };
  CHECK_FALSE(is_frozen(18.0, "stands still"));
  CHECK(is_frozen(12.0, "stands still in 1 stretch, the longest 0.31 s, the first from 15 s on, 3.44% of"));
  CHECK(is_frozen(5.0, "the first from 5 s on"));
}

TEST_CASE("up to 1% that is missing is mirrored, more is refused with the way to a model") {
  const sim::Protocol protocol = two_cycles();
  Recording recording = ramp(891);
  const std::vector<float> sway = bring_to_protocol(recording, protocol).sway_rad();
  CHECK(sway[890] == static_cast<float>(0.890));
  CHECK(sway[891] == static_cast<float>(0.889));
  CHECK(sway[899] == static_cast<float>(0.881));
  CHECK(warns(recording, "lacks 9 samples of the protocol's 900 at its end"));
  Recording shorter = ramp(890);
  check_error([&] { bring_to_protocol(shorter, protocol); }, Code::recording_too_short, "'tiny'");
  Recording half = ramp(300);
  check_error([&] { bring_to_protocol(half, protocol); }, Code::recording_too_short, "300 samples");
}

TEST_CASE("an offset and a drift are those of the whole cycles") {
  const sim::Protocol protocol = two_cycles();
  // The same in each cycle, with a trend within it, from sample 100 on; an offset and a drift of 0.02 mrad a sample.
  const auto make = [&](double offset, double drift) {
    Recording recording = ramp(0);
    for (std::size_t k = 0; k < 900; ++k) {
      const double cycle = static_cast<double>((k + 300) % 400) / 4e5 + (k < 100 ? 0.01 : 0.0);
      recording.signals.at(com_sway).rad.push_back(cycle + offset + drift * static_cast<double>(k));
    }
    return recording;
  };
  Recording plain = make(0.0, 0.0), shifted = make(0.03, 0.0), drifting = make(0.03, 2e-5);
  const std::vector<float> expected = bring_to_protocol(plain, protocol, {.detrend = Detrend::offset}).sway_rad();
  // Rounding to float of values below 0.05.
  constexpr double rounding = 4e-9;
  CHECK(std::abs(mean(expected, 100, 900)) < rounding);
  const std::vector<float> without_offset =
      bring_to_protocol(shifted, protocol, {.detrend = Detrend::offset}).sway_rad();
  const std::vector<float> without_drift =
      bring_to_protocol(drifting, protocol, {.detrend = Detrend::linear}).sway_rad();
  const std::vector<float> untouched = bring_to_protocol(drifting, protocol).sway_rad();
  for (std::size_t k = 0; k < 900; ++k) {
    CHECK(std::abs(without_offset[k] - expected[k]) < rounding);
    CHECK(std::abs(without_drift[k] - expected[k]) < rounding);
    CHECK(untouched[k] == static_cast<float>(drifting.signals.at(com_sway).rad[k]));
  }
  // One cycle: the line of least squares takes a ramp away altogether.
  Recording line = ramp(400);
  for (const float value : bring_to_protocol(line, tiny_protocol(), {.detrend = Detrend::linear}).sway_rad()) {
    CHECK(std::abs(value) < 1e-7);
  }
}

TEST_CASE("signals beside the sway are cut, resampled and detrended as it is, but for the tilt") {
  const sim::Protocol protocol = tiny_protocol();
  for (const double rate : {100.0, 130.0}) {
    Recording recording = with_tilt(protocol, 1.0, 14.0, rate);
    Signal<double> leg{"leg", "LEG (rad)", {}};
    for (const double value : recording.signals.at(com_sway).rad) leg.rad.push_back(-2.0 * value);
    recording.signals.add(leg);
    const Trial trial = bring_to_protocol(recording, protocol, {.detrend = Detrend::linear});
    CHECK(trial.signals.at("leg").column == "LEG (rad)");
    CHECK(trial.signals.at(com_sway).column == "sway");
    const std::vector<float>& legs = trial.signals.at("leg").rad;
    REQUIRE(legs.size() == trial.sway_rad().size());
    CHECK(trial.signals.samples() == legs.size());
    for (std::size_t k = 0; k < legs.size(); ++k) REQUIRE(legs[k] == -2.0F * trial.sway_rad()[k]);
    CHECK(mean(trial.signals.at(platform_tilt).rad, 0, 400) > 0.01);  // its offset of 0.02 is still there
    CHECK(trial.signals.find("trunk") == nullptr);
    check_error([&] { static_cast<void>(trial.signals.at("trunk")); }, Code::column_missing);
  }
}

TEST_CASE("the order of a recording's signals does not change its trial") {
  const sim::Protocol protocol = two_cycles();
  Recording sway_first = with_tilt(protocol, -0.05, 9.0, 100.0), tilt_first = sway_first;
  const Signal<double> sway = tilt_first.signals.at(com_sway);
  tilt_first.signals.remove(com_sway);
  tilt_first.signals.add(sway);
  const Trial expected = bring_to_protocol(sway_first, protocol), trial = bring_to_protocol(tilt_first, protocol);
  CHECK(tilt_first.warnings == sway_first.warnings);
  CHECK(trial.signals.begin()->name == com_sway);
  for (const char* name : {com_sway, platform_tilt}) CHECK(trial.signals.at(name).rad == expected.signals.at(name).rad);
}

TEST_CASE("the measured tilt says where the protocol starts") {
  const sim::Protocol protocol = two_cycles();
  for (const double rate : {100.0, 128.0, 1000.0}) {
    for (const double delay : {0.0, 0.37, 2.5041, 4.0}) {
      CAPTURE(rate);
      CAPTURE(delay);
      Recording recording = with_tilt(protocol, delay, 14.0, rate);
      const Trial trial = bring_to_protocol(recording, protocol);
      REQUIRE(trial.tilt);
      // The correlation's peak is a parabola except at the sequence's corners, states of 5 samples: a tenth of a
      // sample.
      CHECK(std::abs(trial.tilt->delay_s - delay) < 0.001);
      CHECK(trial.tilt->correlation > 0.999);
      CHECK(near(trial.tilt->gain, 1.0, 0.002));
      // The sway says how late it is cut: half a sample where the rates are equal.
      CHECK(std::abs(trial.sway_rad()[450] * 1000.0F - 4.5F) < (rate == 100.0 ? 0.0051F : 0.0015F));
      REQUIRE(trial.signals.at(platform_tilt).rad.size() == 900);
    }
  }
}

TEST_CASE("a recording that starts a little after the stimulus is continued before its start") {
  const sim::Protocol protocol = two_cycles();
  Recording recording = with_tilt(protocol, -0.05, 9.0, 100.0);
  const Trial trial = bring_to_protocol(recording, protocol);
  CHECK(within(trial.tilt->delay_s, -0.05, 1e-9));  // a whole number of samples: the correlation is symmetric
  CHECK(trial.sway_rad()[5] == static_cast<float>(0.05e-3));
  CHECK(trial.sway_rad()[4] == trial.sway_rad()[6]);
  CHECK(warns(recording, "lacks 5 samples"));
  CHECK(warns(recording, "at its start"));
  Recording later = with_tilt(protocol, -0.5, 9.0, 100.0);
  check_error([&] { bring_to_protocol(later, protocol); }, Code::recording_too_short, "0.5");
}

TEST_CASE("a tilt goes on as prescribed beyond the recording's ends, where the sway is mirrored") {
  const sim::Protocol protocol = sim::default_protocol();
  const std::vector<double> prescribed = ProtocolPlan(protocol).tilt_rad();
  const auto check_goes_on = [&](double start_s, double length_s, const TrialOptions& options,
                                 const SampleRange& lacking, std::size_t end) {
    Recording recording = with_tilt(protocol, start_s, length_s, 100.0, 1.2);
    recording.tilt_was_found = options.start_s.has_value();
    const Trial trial = bring_to_protocol(recording, protocol, options);
    REQUIRE(trial.gaps == std::vector<SampleRange>{lacking});
    const std::vector<float>& tilt = trial.signals.at(platform_tilt).rad;
    const double gain = (options.start_s ? trial.tilt_at_given_start : trial.tilt).value().gain;
    double farthest = 0.0;
    for (std::size_t k = lacking.first; k < lacking.end; ++k) {
      const double change = prescribed[k] - prescribed[end];
      CHECK(within(static_cast<double>(tilt[k] - tilt[end]), gain * change, 1e-7));
      farthest = std::max(farthest, std::abs(change));
    }
    CHECK(farthest > 1e-3);
  };
  check_goes_on(0.5, 120.3, {}, {11980, 12100}, 11979);
  check_goes_on(0.5, 120.3, {.start_s = 0.5}, {11980, 12100}, 11979);
  check_goes_on(-1.2, 125.0, {}, {0, 120}, 120);
}

TEST_CASE("the platform's movement before the protocol's start comes from its tilt") {
  const sim::Protocol protocol = two_cycles();
  const sim::Stimulus stimulus = sim::make_stimulus(protocol.experiment);
  const auto with_before = [&](double delay_s, const auto& before, double noise_rad = 0.001) {
    Recording recording = with_tilt(protocol, delay_s, 14.0, 100.0, 1.2, noise_rad);
    std::vector<double>& tilt = recording.signals.at(platform_tilt).rad;
    for (std::size_t k = 0; k < static_cast<std::size_t>(delay_s * 100.0); ++k)
      tilt[k] += 1.2 * before(static_cast<double>(k) / 100.0 - delay_s);
    return recording;
  };
  const auto cautioned = [](const Recording& recording) { return has(recording.warnings, "moved_before"); };
  const double trial_s = protocol.duration_s();
  const auto end_of_trial = [&](double t) { return tilt_at(stimulus, protocol, trial_s + t); };
  Recording at_rest = with_before(3.0, [](double) { return 0.0; });
  CHECK(bring_to_protocol(at_rest, protocol).tilt->moved_before == false);
  CHECK_FALSE(cautioned(at_rest));
  Recording cut = with_before(3.0, end_of_trial);
  const Trial trial = bring_to_protocol(cut, protocol);
  CHECK(trial.tilt->moved_before == true);
  CHECK(within(trial.tilt->delay_s, 3.0, 0.02));
  CHECK_FALSE(cautioned(cut));
  Recording other = with_before(3.0, [](double t) { return 0.07 * t * (t + 3.0); });
  CHECK_FALSE(bring_to_protocol(other, protocol).tilt->moved_before.has_value());
  CHECK(cautioned(other));
  // Noise that leaves a correlation of 0.97 is not a movement, and does not hide one.
  Recording noisy_rest = with_before(
      3.0, [](double) { return 0.0; }, 0.012);
  const Trial of_noise = bring_to_protocol(noisy_rest, protocol);
  CHECK(of_noise.tilt->correlation < 0.98);
  CHECK(of_noise.tilt->moved_before == false);
  CHECK_FALSE(cautioned(noisy_rest));
  Recording noisy_cut = with_before(3.0, end_of_trial, 0.012);
  CHECK(bring_to_protocol(noisy_cut, protocol).tilt->moved_before == true);
  CHECK_FALSE(cautioned(noisy_cut));
  Recording brief = with_before(0.9, end_of_trial);  // too short to tell
  CHECK_FALSE(bring_to_protocol(brief, protocol).tilt->moved_before.has_value());
  CHECK_FALSE(cautioned(brief));
}

TEST_CASE("a noisy, too large, inverted or different tilt is recognised") {
  const sim::Protocol protocol = two_cycles();  // 8 degrees peak to peak, 0.14 rad
  Recording noisy = with_tilt(protocol, 1.0, 12.0, 100.0, 1.0, 0.03);
  CHECK(std::abs(bring_to_protocol(noisy, protocol).tilt->delay_s - 1.0) < 0.02);
  CHECK(warns(noisy, "only roughly"));
  Recording large = with_tilt(protocol, 1.0, 12.0, 100.0, 1.25);
  CHECK(near(bring_to_protocol(large, protocol).tilt->gain, 1.25, 1e-9));
  CHECK(warns(large, "tilted 1.25 times as far"));
  CHECK_FALSE(warns(large, "roughly"));
  Recording inverted = with_tilt(protocol, 1.0, 12.0, 100.0, -1.0);
  check_error([&] { bring_to_protocol(inverted, protocol); }, Code::protocol_mismatch);
  Recording other = with_tilt(protocol, 1.0, 12.0, 100.0, 0.0, 0.03);
  check_error([&] { bring_to_protocol(other, protocol); }, Code::protocol_mismatch, "'tiny'");
  Recording still = with_tilt(protocol, 1.0, 12.0, 100.0, 0.0);
  check_error([&] { bring_to_protocol(still, protocol); }, Code::protocol_mismatch);
  check_error([&] { bring_to_protocol(large, protocol, {.start_s = 1.0}); }, Code::setting_conflict);
}

TEST_CASE("a start that is given: a tilt found by its name is compared with the protocol there") {
  const sim::Protocol protocol = two_cycles();
  const auto brought = [&](double factor, double start_s) {
    Recording recording = with_tilt(protocol, 1.0, 12.0, 100.0, factor);
    recording.tilt_was_found = true;
    const Trial trial = bring_to_protocol(recording, protocol, {.start_s = start_s});
    CHECK_FALSE(trial.tilt);
    const bool removed = std::ranges::count(recording.warnings, "tilt_not_used", &Warning::code) > 0;
    CHECK((trial.signals.find(platform_tilt) == nullptr) == removed);
    CHECK(trial.tilt_at_given_start.has_value() == !removed);
    if (!removed) {
      CHECK(near(trial.tilt_at_given_start->gain, factor, 0.01));
      CHECK(trial.tilt_at_given_start->is_other_size == (factor != 1.0));
    }
    CHECK(near(trial.sway_rad()[100], 1e-3 * start_s, 1e-7));  // floats
    return recording.warnings;
  };
  const auto has = [](const Warnings& warnings, const char* code) {
    return std::ranges::count(warnings, code, &Warning::code) > 0;
  };
  CHECK(worst_trust(brought(1.0, 1.0)) != Trust::not_usable);
  for (const char* code : {"tilt_not_used", "tilt_of_other_size", "tilt_follows_roughly", "time_slips"})
    CHECK_FALSE(has(brought(1.0, 1.0), code));
  CHECK(has(brought(2.0, 1.0), "tilt_of_other_size"));
  for (const auto& [factor, unit] : {std::pair{sim::rad_per_deg, "in radians"},
                                     {1e3 * sim::rad_per_deg, "in milliradians"},
                                     {1.0 / sim::rad_per_deg, "in degrees"}}) {
    const Warnings warnings = brought(factor, 1.0);
    const auto found = std::ranges::find(warnings, "tilt_of_other_size", &Warning::code);
    REQUIRE(found != warnings.end());
    CHECK(found->text.starts_with("give "));
    CHECK(contains(found->text, unit));
  }
  CHECK(worst_trust(brought(-1.0, 1.0)) == Trust::not_usable);
  CHECK(worst_trust(brought(0.0, 1.0)) == Trust::not_usable);
  CHECK(worst_trust(brought(1.0, 2.5)) != Trust::usable);
}

TEST_CASE("a platform that stopped, or began late, is named; it is not a tilt of the other sign") {
  sim::Protocol one = sim::default_protocol();
  one.sequence().cycles = 1;
  const sim::Protocol protocol = sim::default_protocol();
  const double cycle_s = protocol.experiment.cycle_s();
  Recording stopped = with_tilt(one, 0.0, 2.0 * cycle_s, 100.0);
  check_error([&] { bring_to_protocol(stopped, protocol); }, Code::protocol_mismatch, "stopped after 58.");
  Recording late = with_tilt(one, cycle_s, 2.0 * cycle_s, 100.0, 1.0, 1e-4);
  check_error([&] { bring_to_protocol(late, protocol); }, Code::protocol_mismatch, "for the first ");
  Recording reversed = with_tilt(protocol, 0.0, 2.0 * cycle_s, 100.0, -1.0);
  check_error([&] { bring_to_protocol(reversed, protocol); }, Code::protocol_mismatch, "other sign");
  // Half of the noisy tilt's variance is noise: its correlation is -0.7.
  Recording unsure = with_tilt(protocol, 0.0, 2.0 * cycle_s, 100.0, -1.0, 0.003);
  check_error([&] { bring_to_protocol(unsure, protocol); }, Code::protocol_mismatch, "does not follow");
  // A rest after the whole protocol is not used.
  Recording longer = with_tilt(protocol, 0.0, 3.0 * cycle_s, 100.0);
  CHECK(within(bring_to_protocol(longer, protocol).tilt->delay_s, 0.0, 1e-6));
}

TEST_CASE("errors and warnings about samples in memory name no files, columns or options") {
  const sim::Protocol protocol = two_cycles();
  const auto check_plain = [](const std::string& text) {
    INFO(text);
    for (const char* part : {"--", "decid ", "column", "r.csv"}) CHECK_FALSE(contains(text, part));
  };
  const auto refused = [&](Recording recording, const TrialOptions& options = {}) {
    recording.file.clear();
    const Error error = error_of([&] { bring_to_protocol(recording, protocol, options); });
    CHECK(error.where() == "recording");
    CHECK_FALSE(error.remedy().empty());
    check_plain(error.what());
  };
  refused(ramp(300));
  refused(ramp(890));
  refused(ramp(900), {.start_s = 9.5});
  refused(with_tilt(protocol, 1.0, 12.0, 100.0), {.start_s = 1.0});
  refused(with_tilt(protocol, 1.0, 12.0, 100.0, -1.0));
  refused(with_tilt(protocol, 1.0, 12.0, 100.0, 0.0, 0.03));
  for (Recording recording : {ramp(1200), ramp(895), with_tilt(protocol, 1.0, 12.0, 100.0, 1.25, 0.03)}) {
    recording.file.clear();
    bring_to_protocol(recording, protocol);
    CHECK_FALSE(recording.warnings.empty());
    for (const Warning& warning : recording.warnings) check_plain(warning.text);
  }
}

TEST_CASE("a rate below 25 Hz is a caution, below 5 Hz an error, unless it is the protocol's own") {
  const sim::Protocol protocol = two_cycles();
  const auto severity = [&](double rate_hz) -> std::optional<Severity> {
    Recording recording = ramp(static_cast<std::size_t>(9.0 * rate_hz), rate_hz);
    bring_to_protocol(recording, protocol);
    for (const Warning& warning : recording.warnings)
      if (warning.code == "slow_rate") return warning.severity;
    return {};
  };
  CHECK(severity(5.0) == Severity::caution);
  CHECK(severity(20.0) == Severity::caution);
  CHECK_FALSE(severity(24.9));  // a webcam's 25 Hz
  CHECK_FALSE(severity(30.0));
  Recording slow = ramp(36, 4.0);
  check_error([&] { bring_to_protocol(slow, protocol); }, Code::protocol_mismatch, "4 Hz");
  slow.rate_advice = "name it time_ms";
  check_error([&] { bring_to_protocol(slow, protocol); }, Code::protocol_mismatch, "time_ms");
  sim::Protocol own = protocol;
  own.experiment.sample_rate_hz = 4;
  Recording same = ramp(36, 4.0);
  CHECK(bring_to_protocol(same, own).sway_rad().size() == 36);
  for (const Warning& warning : same.warnings) CHECK(warning.code != "slow_rate");
}

TEST_CASE("COMTEST's published stimulus is recognised if the protocol is short") {
  sim::Protocol comtest = sim::short_protocol();
  comtest.sequence().offset_s = 9.12;
  const sim::Protocol short_one = sim::short_protocol();
  // To the protocol `short` it is nearly the same movement upside down, 0.88 s later.
  Recording recording = with_tilt(comtest, 0.5, 65.0, 100.0, 1.0, 1e-4);
  check_error([&] { bring_to_protocol(recording, short_one); }, Code::protocol_mismatch, "'short'");
  Recording found = with_tilt(comtest, 0.5, 65.0, 100.0, 1.0, 1e-4);
  found.tilt_was_found = true;
  bring_to_protocol(found, short_one);
  CHECK(worst_trust(found.warnings) == Trust::not_usable);
  CHECK(warns(found, "COMTEST"));
  Recording fits = with_tilt(comtest, 0.5, 65.0, 100.0, 1.0, 1e-4);
  CHECK(within(bring_to_protocol(fits, comtest).tilt->delay_s, 0.5, 1e-3));
  // With the sign reversed, the protocol's own tilt is still recognised.
  Recording inverted = with_tilt(short_one, 0.5, 65.0, 100.0, -1.0, 1e-4);
  check_error([&] { bring_to_protocol(inverted, short_one); }, Code::protocol_mismatch);
  // Other protocols have nothing to do with it.
  Recording other = with_tilt(comtest, 0.5, 130.0, 100.0);
  check_error([&] { bring_to_protocol(other, sim::default_protocol()); }, Code::protocol_mismatch, "'default'");
}

TEST_CASE("where a part is not used, the column that may tell recordings apart is named") {
  for (const std::optional<double> start_s : {std::optional<double>(), std::optional(1.0)}) {
    Recording recording = ramp(1800);
    recording.change = "'who' changes";
    bring_to_protocol(recording, two_cycles(), {.start_s = start_s});
    const auto found = std::ranges::find(recording.warnings, "part_not_used", &Warning::code);
    REQUIRE(found != recording.warnings.end());
    CHECK(found->text.ends_with(" 'who' changes"));
    CHECK(std::ranges::find(recording.warnings, "perhaps_several", &Warning::code) == recording.warnings.end());
  }
  // A trigger may also be the start, unless that is known or the protocol does not fit behind it.
  const auto names_begin = [](double change_s, std::optional<double> start_s) {
    Recording triggered = ramp(1800);
    triggered.change = "'trigger' changes";
    triggered.change_s = change_s;
    bring_to_protocol(triggered, two_cycles(), {.start_s = start_s});
    return contains(std::ranges::find(triggered.warnings, "part_not_used", &Warning::code)->text, "begin 1.5");
  };
  CHECK(names_begin(1.5, {}));
  CHECK_FALSE(names_begin(1.5, 1.0));
  CHECK_FALSE(names_begin(15.5, {}));
  // Where the whole file is used, a note names it.
  Recording whole = ramp(static_cast<std::size_t>(two_cycles().samples()));
  whole.change = "'who' changes";
  bring_to_protocol(whole, two_cycles());
  const auto note = std::ranges::find(whole.warnings, "perhaps_several", &Warning::code);
  REQUIRE(note != whole.warnings.end());
  CHECK(note->severity == Severity::info);
  CHECK(note->text == "'who' changes");
  CHECK(std::ranges::find(whole.warnings, "part_not_used", &Warning::code) == whole.warnings.end());
}
