// Draws the recorded frequency response over the band of each controller, for the pages of decid fit. After common.js and plot.js.

// Returns a figure with a panel per controller; all have the same axes. answers: [{ controller, frf }]; frf: frequency_hz, and gain and
// phase_deg, model_gain and model_phase_deg, model_gain_interval90 and model_phase_interval90. bandName, lineName: in the
// legend.
function responsesFigure(answers, [bandName, lineName], caption) {
  const frequencies = answers[0].frf.frequency_hz, x = { text: "Frequency (Hz)", logarithmic: true, low: frequencies[0], high: frequencies.at(-1) };
  const limits = (recorded, interval) => {
    const all = answers.flatMap(({ frf }) => [...frf[recorded], ...frf[interval].flat()]).filter(value => recorded !== "gain" || value > 0);
    return [Math.min(...all), Math.max(...all)];
  };
  const [least, most] = limits("gain", "model_gain_interval90"), [lowest, highest] = limits("phase_deg", "model_phase_interval90");
  const axes = { gain: { text: "Gain (\u00b0/\u00b0)", logarithmic: true, low: least / 1.1, high: 1.1 * most }, phase_deg: { text: "Phase (\u00b0)", low: lowest - 10, high: highest + 10 } };
  const chart = ({ controller, frf }, key, interval, legend) => plot({ title: `${key === "gain" ? "Gain" : "Phase"} of the recorded response and of ${controller} over frequency`,
    height: key === "gain" ? 280 : 220, sheet: answers.length > 1 ? 334 : 688, legend, x, y: axes[key],
    marks: [{ name: bandName, class: "again-soft", band: frequencies.map((at, i) => [at, ...frf[interval][i]]) },
      { name: lineName, class: "again dashed", line: frequencies.map((at, i) => [at, frf[`model_${key}`][i]]) },
      { name: "Recorded", class: "draw", line: frequencies.map((at, i) => [at, frf[key][i]]), dots: true }] }).made;
  const panel = answer => element("div", {}, element("h4", {}, answer.controller), chart(answer, "gain", "model_gain_interval90", true),
    chart(answer, "phase_deg", "model_phase_interval90", false));
  return element("figure", {}, element("h3", {}, "Recorded response and each controller\u2019s"), element("div", { class: "panels responses" }, ...answers.map(panel)),
    element("figcaption", {}, caption));
}
