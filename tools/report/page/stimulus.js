// Draws the page of decid stimulus, after common.js.
(() => {
const stimulus = report;

function chart(title, caption, { label, x, y, points, stepped = false }) {
  const line = points.x.map((at, k) => [at, points.y[k]]);
  document.getElementById("main").append(chartFigure(title, caption, plot({ title: label, x, y,
    marks: [{ name: title, class: "draw", line, stepped, dots: line.length < 200 }] })));
}

const { name, kind, duration_s, sample_rate_hz, cycles, cycle_s, lead_in_s, peak_to_peak_deg, fastest_deg_s } = stimulus;
document.title = `${name} \u2013 stimulus`;
document.getElementById("main").append(element("h2", {}, `Protocol \u201c${name}\u201d`), element("dl", { class: "figures" },
  figure("Stimulus", kind, `sampled at ${compact(sample_rate_hz)} Hz`),
  figure("Trial", `${compact(duration_s)} s`, `${cycles} cycle${cycles === 1 ? "" : "s"} of ${compact(cycle_s)} s` +
    (lead_in_s > 0 ? ` after ${compact(lead_in_s)} s at rest` : "")),
  figure("Tilt, peak to peak", `${compact(peak_to_peak_deg)} deg`, "of the platform in space"),
  figure("Fastest", `${compact(fastest_deg_s)} deg/s`, "largest velocity, either way")));
const end = `${compact(duration_s)} s`;
chart("Tilt", "0 is the tilt at the start of the trial.",
  { label: `Line chart: platform tilt over ${end}`, x: { text: "Time (s)", low: 0, high: duration_s }, y: { text: "Tilt (deg)" }, points: stimulus.tilt });
chart("Velocity", "Of the straight lines between the samples, as the platform of the simulation moves.",
  { label: `Line chart: platform velocity over ${end}`, x: { text: "Time (s)", low: 0, high: duration_s },
    y: { text: "Velocity (deg/s)" }, points: stimulus.velocity, stepped: true });
chart("Amplitude spectrum", "Of one cycle, its mean removed: the amplitude of each harmonic. Harmonics below a millionth of " +
  "the largest are left out: the cycle does not hold them.",
  { label: "Line chart: amplitude of the tilt over frequency, both logarithmic", x: { text: "Frequency (Hz)", logarithmic: true },
    y: { text: "Amplitude (deg)", logarithmic: true }, points: stimulus.spectrum });
document.getElementById("footer").append(element("p", {}, "decid ", stimulus.version, "."));
finish();
})();
