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
  figure("Tilt, peak to peak", `${compact(peak_to_peak_deg)}\u00b0`, "of the platform in space"),
  figure("Fastest", `${compact(fastest_deg_s)} \u00b0/s`, "largest velocity, either way")));
const end = `${compact(duration_s)} s`;
chart("Tilt", "0 is the tilt at the start of the trial.",
  { label: `Line chart: platform tilt over ${end}`, x: { text: "Time (s)", low: 0, high: duration_s }, y: { text: "Tilt (\u00b0)" }, points: stimulus.tilt });
chart("Velocity", "The simulated platform moves in straight lines between the samples.",
  { label: `Line chart: platform velocity over ${end}`, x: { text: "Time (s)", low: 0, high: duration_s },
    y: { text: "Velocity (\u00b0/s)" }, points: stimulus.velocity, stepped: true });
chart("Amplitude spectrum", "Amplitude of each harmonic of one cycle, without its mean. Harmonics below a millionth of the largest are not shown.",
  { label: "Line chart: amplitude of the tilt over frequency, both logarithmic", x: { text: "Frequency (Hz)", logarithmic: true },
    y: { text: "Amplitude (\u00b0)", logarithmic: true }, points: stimulus.spectrum });
document.getElementById("footer").append(element("p", {}, "decid ", stimulus.version, "."), ...callTexts(stimulus.call, ""));
finish();
})();
