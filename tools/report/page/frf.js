// Draws the frequency response of a recording and of the identified controller: gain, phase and coherence over a
// logarithmic axis. After plot.js, before identify.js.

// Draws a chart. lines: [name, class, values]; the first line has dots. low and high bound the band around it. The first
// chart has the legend of all charts.
function frfChart(frf, title, y, lines, { low, high, legend = false } = {}) {
  const { frequency_hz } = frf, points = values => frequency_hz.map((x, i) => [x, values[i] ?? NaN]);
  const band = low ? [{ name: "95% confidence of the recording", class: "soft", band: frequency_hz.map((x, i) => [x, low[i] ?? NaN, high[i] ?? NaN]) }] : [];
  const shown = lines.filter(([, , values]) => values.some(value => !absent(value)));
  return plot({ title, x: { text: "Frequency (Hz)", logarithmic: true, low: frequency_hz[0], high: frequency_hz.at(-1) }, y, height: 280, legend,
    marks: [...band, ...shown.map(([name, kind, values]) => ({ name, class: kind, line: points(values), dots: kind === "draw" }))] });
}

function frfFigure(recording) {
  const { frf } = recording;
  if (!frf || frf.frequency_hz.length < 2) return null;
  const gains = [...frf.gain, ...frf.model_gain, ...frf.linear_gain].filter(value => value > 0);
  const floor = 0.3 * Math.min(...gains);  // where a band that reaches 0 leaves a logarithmic axis
  const known = frf.gain_high.some(value => !absent(value));
  const curves = key => [["Recording", "draw", frf[key]], ["Model", "again dashed", frf[`model_${key}`]],
    ["Model without its tilt-speed threshold", "tilt dotted", frf[`linear_${key}`]]];
  const phases = curves("phase_deg");
  if (known) phases[0][2] = frf.phase_deg.map((value, i) => absent(frf.phase_low_deg[i]) ? null : value);
  const charts = [
    frfChart(frf, `Gain of sway over tilt, ${frf.gain.length} bands from ${compact(frf.frequency_hz[0])} to ${compact(frf.frequency_hz.at(-1))} Hz`,
      { text: "Gain (\u00b0/\u00b0)", logarithmic: true, low: floor }, curves("gain"),
      { low: known && frf.gain_low.map(value => absent(value) ? value : Math.max(value, floor)), high: frf.gain_high, legend: true }),
    frfChart(frf, "Phase of sway relative to tilt", { text: "Phase (\u00b0)" }, phases,
      { low: known && frf.phase_low_deg, high: frf.phase_high_deg }),
    ...(known ? [frfChart(frf, "Coherence of sway and tilt", { text: "Coherence", low: 0, high: 1 }, [["Recording", "draw", frf.coherence]])] : []),
  ];
  return chartFigure("Frequency response to the platform\u2019s tilt",
    `Sway over tilt at the harmonics of the stimulus, from ${frf.cycles} cycle${frf.cycles === 1 ? "" : "s"}, neighbours averaged. ` +
      (known ? "Band: 95% confidence, from the noise at frequencies that the stimulus does not contain. The phase is not shown where it is undetermined. " +
        "Where coherence is low, the recording does not determine the response. " : "The stimulus contains all frequencies, so there is no estimate of the noise and no band. ") +
      "A model that explains the recording has its curves within the band.", ...charts);
}
