// Draws the report of decid identify, after common.js, recordings.js and density.js.
(() => {
// ---- certainty -----------------------------------------------------------------------------------------------------

function certainty(recording) {
  return [densityFigure("Certainty of each estimate", recording.parameters, recording.densities,
    report.model.recalibrated ? " Simulated trials outside the training have corrected the intervals."
      : " No trials outside the training have checked the intervals."),
    element("details", { class: "help" }, element("summary", {}, "Which estimates depend on each other"), correlationTable(recording))];
}

// ---- sway ----------------------------------------------------------------------------------------------------------

// Returns the values of a list that holds the steps from each value to the next.
function summed(list) {
  let sum = 0;
  return list.map(step => step === null ? null : sum += step);
}

// Points in degrees. Sway is drawn about its mean over the fitted span, as the residual is computed.
function swayPoints(recording) {
  const { per_degree } = recording.series, { platform } = report;
  const sway = summed(recording.series.sway), fitted = summed(recording.series.fitted);
  const rate = recording.protocol.sample_rate_hz;
  const span = fitted.length || sway.length;
  const mean = list => {
    const finite = list.slice(0, span).filter(value => value !== null);
    return finite.length ? finite.reduce((sum, value) => sum + value, 0) / finite.length : 0;
  };
  const points = (list, origin, scale) => list.map((value, k) => [k / rate, value === null ? NaN : (value - origin) / scale]);
  return { sway: points(sway, mean(sway), per_degree), fitted: points(fitted, mean(fitted), per_degree),
    tilt: points(summed(platform.tilt), 0, platform.per_degree) };
}

const swayChart = (points, title, end) => plot({ title, x: { text: "Time (s)", low: 0, high: end }, y: { text: "Angle (\u00b0)" },
  marks: [["Recorded sway", "sway", "draw"], ["Model\u2019s sway without noise", "fitted", "again"], ["Platform tilt", "tilt", "tilt"]]
    .map(([name, key, kind]) => ({ name, class: kind, line: points[key] })) });

function windowFigure(recording, points, end) {
  const { cycles, cycle_s, lead_in_s } = recording.protocol;
  const choices = [["5 s", 5], ["10 s", 10], ["20 s", 20], ["one stimulus cycle", cycle_s]].filter(([, seconds]) => seconds < end);
  if (choices.length === 0) return null;
  const chosen = Math.min(2, choices.length - 1);
  // The last cycle, when the start has died away; the beginning, if the fit ended before that.
  const last = Math.min(lead_in_s + (cycles - 1) * cycle_s, end - choices[chosen][1]);
  const first = points.fitted.length > 0 && points.fitted.at(-1)[0] < last ? 0 : last;
  const chart = swayChart(points, "Line chart: a part of the recorded sway, the model\u2019s sway and the platform tilt", end);
  return element("figure", { class: "closer" }, element("h3", {}, "A closer look"),
    windowControls(choices, chosen, first, end, chart.draw), chart.made);
}

// ---- images --------------------------------------------------------------------------------------------------------

const palettes = {  // viridis, red-blue, and a wheel that ends where it begins
  sequential: ["#440154", "#482878", "#3e4a89", "#31688e", "#26828e", "#1f9e89", "#35b779", "#6ece58", "#b5de2b", "#fde725"],
  diverging: ["#2166ac", "#67a9cf", "#d1e5f0", "#f7f7f7", "#fddbc7", "#ef8a62", "#b2182b"],
  cyclic: ["#e2d9e2", "#91b1c8", "#5f6fb9", "#4b2a83", "#2f1436", "#6b1d4b", "#ab4b50", "#cb9a84", "#e2d9e2"],
};

const rgb = hex => [1, 3, 5].map(at => parseInt(hex.slice(at, at + 2), 16));

// Returns 256 colours.
function colourTable(kind) {
  const stops = palettes[kind].map(rgb);
  return Array.from({ length: 256 }, (_, level) => {
    const place = level / 255 * (stops.length - 1);
    const below = Math.min(Math.floor(place), stops.length - 2);
    return stops[below].map((value, channel) => Math.round(value + (place - below) * (stops[below + 1][channel] - value)));
  });
}

// Returns the address of a picture with a pixel a value.
function bitmap(width, height, colourAt) {
  const canvas = element("canvas", { width, height }), context = canvas.getContext("2d"), pixels = context.createImageData(width, height);
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) pixels.data.set([...(colourAt(x, y) ?? [255, 255, 255]), 255], 4 * (y * width + x));
  }
  context.putImageData(pixels, 0, 0);
  return canvas.toDataURL();
}

const channelTitles = {
  modulus: "Modulus", log_modulus: "Logarithm of the modulus", phase: "Phase", cos_phase: "Cosine of the phase",
  sin_phase: "Sine of the phase", real: "Real part", imaginary: "Imaginary part", asinh_real: "Real part, asinh",
  asinh_imaginary: "Imaginary part, asinh", log_residual: "Logarithm of the difference between cycles",
};
const channelUnits = { modulus: "rad", log_modulus: "ln rad", phase: "rad", real: "rad", imaginary: "rad", log_residual: "ln rad" };

const timeLabel = image => image.fold > 1
  ? "Time in the cycle (s)"
  : image.start_s > 0 ? `Time after ${compact(image.start_s)} s (s)` : "Time (s)";

// The colours of a heat map from its lowest to its highest value.
function colourScale(channel) {
  const limit = value => absent(value) ? "n/a" : channel.logarithmic ? minus((10 ** value).toExponential(0).replace("e+0", "")) : compact(value);
  const colours = element("span", { class: "colours", "aria-hidden": "true" });
  colours.style.background = `linear-gradient(to right, ${palettes[channel.kind].join(", ")})`;
  return element("p", { class: "legend" }, limit(channel.low), colours, `${limit(channel.high)} ${channelUnits[channel.name] ?? ""}`);
}

function heatmap(image, channel) {
  const colour = colourTable(channel.kind);
  const level = (x, y) => channel.levels[(image.rows - 1 - y) * image.columns + x];  // low frequencies below
  const title = (channelTitles[channel.name] ?? channel.name) + (channel.logarithmic ? ", logarithmic colours" : "");
  const half = image.row_hz / 2, highest = image.rows * image.row_hz - half;
  const { made } = plot({ title: `Heat map: ${title} of the sway\u2019s spectrum, ${timeLabel(image)} 0 to ${compact(image.columns * image.column_s)} s across, ` +
    `frequency 0 to ${compact((image.rows - 1) * image.row_hz)} Hz upwards`,
    x: { text: timeLabel(image), low: 0, high: image.columns * image.column_s }, y: { text: "Frequency (Hz)", low: -half, high: highest },
    marks: [{ image: bitmap(image.columns, image.rows, (x, y) => colour[level(x, y)]) }], height: 272, sheet: 330 });
  return element("div", {}, element("h4", {}, title), made, colourScale(channel));
}

function imageFigure(image) {
  return element("details", { class: "help" }, element("summary", {}, "Network input (for people who train networks)"), element("figure", {},
    element("div", { class: "panels" }, ...image.channels.map(channel => heatmap(image, channel))),
    element("figcaption", {}, `Spectrum of each ${compact(image.column_s)} s of sway, one column per window. ` +
      (image.fold > 1 ? `The ${image.fold} equal cycles of the stimulus are averaged. ` : "") +
      (image.mirrored ? "Rows above half the sample rate mirror these and are not shown. " : "") +
      "Values beyond a colour scale have its last colour. These pictures are the network\u2019s input, not a result.")));
}

// ---- the page ------------------------------------------------------------------------------------------------------

const explained = ({ variance_accounted_for: part }) => part <= 0 ? "none" : percent(part);

function fill(made, recording) {
  made.append(trustBox(recording));
  made.append(element("h3", {}, "Estimates"), parameterTable(recording), nextSteps(recording), ...aboutRecording(recording),
    howToRead("The network\u2019s estimate from this recording."));
  if ("densities" in recording) made.append(...certainty(recording));
  made.append(element("dl", { class: "figures" },
    figure("Sway, peak to peak", inDegrees(recording.peak_to_peak_deg, 2), "of the recording"),
    figure("Share explained without noise", explained(recording), "of the recording\u2019s variance; low is expected at high sensory noise"),
    figure("Residual, rms", inDegrees(recording.rms_residual_deg, 3), "recorded sway minus the model\u2019s sway")));

  const { sway, fitted } = recording.series;
  if (sway.length > 1) {
    const end = (sway.length - 1) / recording.protocol.sample_rate_hz;
    const points = swayPoints(recording);
    const whole = swayChart(points, `Line chart over ${compact(end)} s: recorded sway, ` +
      `${inDegrees(recording.peak_to_peak_deg, 2)} peak to peak, the model\u2019s sway and platform tilt`, end);
    const fell = fitted.length < sway.length
      ? ` The body simulated from these estimates falls after ${fixed(fitted.length / recording.protocol.sample_rate_hz, 1)} s, so its line ends there.` : "";
    made.append(chartFigure("Recorded sway and the model\u2019s sway", "Each sway is shown about its mean. The model\u2019s sway is simulated from the estimates without " +
      "noise, so it does not contain the random part of the recording." + fell, whole));
    const close = windowFigure(recording, points, end);
    if (close) made.append(close);
  }
  const response = frfFigure(recording);
  if (response) made.append(response);
  if (recording.image) {
    const saw = imageFigure(recording.image);
    made.append(saw);
    saw.addEventListener("toggle", redraw);
  }
}

function footer() {
  const { name, sha256, version, options, protocol } = report.model;
  document.getElementById("footer").append(
    element("p", {}, element("strong", {}, "This is not a diagnosis. "),
      "A neural network estimates the parameters of a simplified model of posture control from this recording. " +
      "The model is a single inverted pendulum under disturbance estimation and compensation (DEC). The values hold for the stated " +
      "protocol only, and contain the errors of model, network and measurement."),
    element("p", {}, "decid ", version, ", model \u201c", name, "\u201d, SHA-256 of its weights ", element("code", {}, sha256),
      ", protocol \u201c", protocol, "\u201d", ...(options.length > 0 ? [", options ", element("code", {}, options.join(" "))] : []), "."), ...callTexts(report.model.call));
}

if (report.recordings.length === 1) document.title = `${report.recordings[0].file} \u2013 balance control report`;
contents(valueOf,
  ["Explained", explained]);
failures("Not analysed");
sections(fill);
footer();
finish();
})();
