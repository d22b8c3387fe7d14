// Draws the page of decid stimulus, after common.js.
(() => {
const stimulus = report;
const colour = "#17527f";

function chart(title, caption, { label, x, y, points, xMax, xLogarithmic = false, yLogarithmic = false, stepped = false }) {
  const canvas = element("canvas", { role: "img", "aria-label": label });
  document.getElementById("main").append(element("figure", {}, element("h3", {}, title),
    element("div", { class: "chart" }, canvas), element("figcaption", {}, caption)));
  const scale = (text, logarithmic) => {
    const made = axis(text);
    return logarithmic ? { ...made, type: "logarithmic", ticks: { ...made.ticks, callback: (value, index, ticks) =>
      ticks[index].major || ticks.length < 12 ? String(value) : "" } } : made;
  };
  const pairs = points.x.map((at, k) => ({ x: at, y: points.y[k] }));
  new Chart(canvas, {
    type: "line",
    data: { datasets: [{ label: title, data: pairs, borderColor: colour, backgroundColor: colour, stepped,
      borderWidth: 1.4, pointRadius: pairs.length < 200 ? 2 : 0, pointHitRadius: 6 }] },
    options: {
      animation: false, normalized: true, parsing: false, responsive: true, maintainAspectRatio: false,
      interaction: { mode: "nearest", axis: "x", intersect: false },
      scales: { x: { ...scale(x, xLogarithmic), max: xMax }, y: scale(y, yLogarithmic) },
      plugins: { legend: { display: false }, tooltip: { callbacks: {
        title: items => items.length ? `${x}: ${compact(items[0].parsed.x)}` : "",
        label: item => `${y}: ${minus(String(Number(item.parsed.y.toPrecision(4))))}` } } },
    },
  });
  checks.push(() => pairs.length === 0 || hasColour(canvas, colour));
}

const { name, kind, duration_s, sample_rate_hz, cycles, cycle_s, lead_in_s, peak_to_peak_deg, fastest_deg_s } = stimulus;
document.title = `${name} \u2013 stimulus`;
document.querySelector("h1").textContent = `Stimulus of protocol \u201c${name}\u201d`;
document.getElementById("main").append(element("dl", { class: "figures" },
  figure("Stimulus", kind, `sampled at ${compact(sample_rate_hz)} Hz`),
  figure("Trial", `${compact(duration_s)} s`, `${cycles} cycle${cycles === 1 ? "" : "s"} of ${compact(cycle_s)} s` +
    (lead_in_s > 0 ? ` after ${compact(lead_in_s)} s at rest` : "")),
  figure("Tilt, peak to peak", `${compact(peak_to_peak_deg)} deg`, "of the platform in space"),
  figure("Fastest", `${compact(fastest_deg_s)} deg/s`, "largest velocity, either way")));
const end = `${compact(duration_s)} s`;
chart("Tilt", "0 is the tilt at the start of the trial.",
  { label: `Line chart: platform tilt over ${end}`, x: "Time (s)", y: "Tilt (deg)", points: stimulus.tilt, xMax: duration_s });
chart("Velocity", "Of the straight lines between the samples, as the platform of the simulation moves.",
  { label: `Line chart: platform velocity over ${end}`, x: "Time (s)", y: "Velocity (deg/s)", points: stimulus.velocity, xMax: duration_s, stepped: true });
chart("Amplitude spectrum", "Of one cycle, its mean removed: the amplitude of each harmonic. Harmonics below a millionth of " +
  "the largest are left out: the cycle does not hold them.",
  { label: "Line chart: amplitude of the tilt over frequency, both logarithmic", x: "Frequency (Hz)", y: "Amplitude (deg)",
    points: stimulus.spectrum, xLogarithmic: true, yLogarithmic: true });
document.getElementById("footer").append(element("p", {}, "decid ", stimulus.version, "."));
finish();
})();
