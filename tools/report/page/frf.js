// Draws the frequency response of a recording and of the identified controller: gain, phase and coherence over a
// logarithmic axis. After common.js, before identify.js.
const frfColours = { recorded: "#17527f", band: "rgba(23, 82, 127, 0.18)", model: "#d1541f", linear: "#6f7780" };

const decades = text => ({ ...axis(text), type: "logarithmic",
  ticks: { color: "#3d4853", callback: value => /^[125]/.test(Number(value).toExponential()) ? compact(value) : "" } });

// lines: [label, colour, values, dash]; low and high bound the band around the first of them.
function frfChart(frf, label, y, lines, low, high) {
  const canvas = element("canvas", { role: "img", "aria-label": label });
  const points = values => frf.frequency_hz.map((x, i) => ({ x, y: absent(values[i]) ? NaN : values[i] }));
  const edge = { borderWidth: 0, pointRadius: 0, pointHitRadius: 0, backgroundColor: frfColours.band };
  const datasets = lines.filter(([, , values]) => values.some(value => !absent(value)))
    .map(([name, colour, values, dash]) => ({ label: name, data: points(values), borderColor: colour, backgroundColor: colour,
      borderWidth: 1.6, borderDash: dash ?? [], pointRadius: dash ? 0 : 2.5, pointHitRadius: 6 }));
  if (low) datasets.push({ ...edge, label: "95 %", data: points(high), fill: "+1" }, { ...edge, label: "", data: points(low), fill: false });
  const start = () => {
    const chart = new Chart(canvas, {
      type: "line",
      data: { datasets },
      options: {
        animation: false, parsing: false, responsive: true, maintainAspectRatio: false,
        interaction: { mode: "nearest", axis: "x", intersect: false },
        scales: { x: { ...decades("Frequency (Hz)"), min: frf.frequency_hz[0], max: frf.frequency_hz.at(-1) }, y },
        plugins: {
          legend: { position: "top", align: "end", labels: { color: "#1c2733", filter: item => item.text !== "" } },
          tooltip: { filter: item => item.dataset.label !== "" && item.dataset.label !== "95 %",
            callbacks: { title: items => items.length ? `${compact(items[0].parsed.x)} Hz` : "",
              label: item => `${item.dataset.label}: ${compact(item.parsed.y)}` } },
        },
      },
    });
    checks.push(() => chart.data.datasets.every(({ borderColor }) => !borderColor || hasColour(canvas, borderColor)));
  };
  return { holder: element("div", { class: "chart" }, canvas), start };
}

function frfFigure(recording) {
  const { frf } = recording;
  if (!frf || frf.frequency_hz.length < 2) return null;
  const { recorded, model, linear } = frfColours;
  const gains = [...frf.gain, ...frf.model_gain, ...frf.linear_gain].filter(value => value > 0);
  const floor = 0.3 * Math.min(...gains);  // where a band that reaches 0 leaves a logarithmic axis
  const known = frf.gain_high.some(value => !absent(value));
  const names = ["Recording", "Identified controller, simulated", "Identified controller without its dead band"];
  const curves = key => [[names[0], recorded, frf[key]], [names[1], model, frf[`model_${key}`], [6, 3]],
    [names[2], linear, frf[`linear_${key}`], [2, 3]]];
  const phases = curves("phase_deg");
  if (known) phases[0][2] = frf.phase_deg.map((value, i) => absent(frf.phase_low_deg[i]) ? null : value);
  const charts = [
    frfChart(frf, `Gain of sway over tilt, ${frf.gain.length} bands from ${compact(frf.frequency_hz[0])} to ${compact(frf.frequency_hz.at(-1))} Hz`,
      { ...decades("Gain (deg/deg)"), min: floor }, curves("gain"),
      known && frf.gain_low.map(value => absent(value) ? value : Math.max(value, floor)), frf.gain_high),
    frfChart(frf, "Phase of sway relative to tilt", axis("Phase (deg)"), phases, known && frf.phase_low_deg, frf.phase_high_deg),
    known ? frfChart(frf, "Coherence of sway and tilt", { ...axis("Coherence"), min: 0, max: 1 }, [[names[0], recorded, frf.coherence]]) : null,
  ].filter(chart => chart !== null);
  const made = element("figure", {}, element("h3", {}, "Frequency response to the platform\u2019s tilt"),
    ...charts.map(chart => chart.holder),
    element("figcaption", {}, `Sway over tilt at the harmonics of the stimulus, from ${frf.cycles} cycle${frf.cycles === 1 ? "" : "s"}, neighbours averaged. ` +
      (known ? "Shaded: what the 95 % confidence circle about the response spans, its noise taken from frequencies that the " +
        "stimulus leaves out; where the circle holds zero the phase is undetermined and left out. Where coherence is low, the recording " +
        "says nothing about the response. " : "All frequencies of the stimulus are excited, so there is none to read the noise from, and no band. ") +
      "A controller that explains the recording has its curves within the band."));
  return { made, start: () => charts.forEach(chart => chart.start()) };
}
