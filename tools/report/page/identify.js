// Draws the report of decid identify, after common.js, recordings.js and density.js.
(() => {
const colours = { sway: "#17527f", fitted: "#d1541f", tilt: "#6f7780" };

// ---- tables --------------------------------------------------------------------------------------------------------

function rangeCell(parameter) {
  const place = value => 100 * (value - parameter.low) / (parameter.high - parameter.low);
  const bar = element("div", { class: "bar", "aria-hidden": "true" });
  const mark = (value, kind) => {
    if (absent(value)) return;
    const at = place(value);
    const made = element("span", { class: kind + (kind === "value-mark" && parameter.beyond ? " outside" : "") });
    made.style.left = Math.min(100, Math.max(0, at)) + "%";
    bar.append(made);
  };
  if ("interval90" in parameter) {
    const [from, to] = parameter.interval90.map(value => Math.min(100, Math.max(0, place(value))));
    const span = element("span", { class: "interval" });
    Object.assign(span.style, { left: from + "%", width: to - from + "%" });
    bar.append(span);
  }
  mark(parameter.true, "truth-mark");
  mark(parameter.value, "value-mark");
  const decimals = decimalsOf(parameter);
  return element("td", { class: "range" }, bar,
    element("div", { class: "limits" }, element("span", {}, fixed(parameter.low, decimals)),
      parameter.beyond && !absent(parameter.value) ? element("strong", {}, "outside the range") : null,
      element("span", {}, fixed(parameter.high, decimals))));
}

// Of a network that gives a distribution.
const isSure = recording => recording.parameters.some(parameter => "sd" in parameter);
const finest = parameter => "sd" in parameter ? finestOf(parameter) : decimalsOf(parameter);
const valueOf = parameter => fixed(parameter.value, finest(parameter)) +
  ("sd" in parameter ? ` \u00b1 ${fixed(parameter.sd, finest(parameter))}` : "");

function parameterTable(recording) {
  const known = recording.parameters.some(parameter => "true" in parameter), sure = isSure(recording);
  const number = text => element("th", { scope: "col", class: "number" }, text);
  const head = element("tr", {}, element("th", { scope: "col" }, "Parameter"), number(sure ? "Value \u00b1 deviation" : "Value"),
    sure ? number("90 % interval") : null, known ? number("True") : null, number("Value / (m g h)"),
    element("th", { scope: "col" }, "Place in the model\u2019s range"));
  const rows = recording.parameters.map(parameter => {
    const decimals = finest(parameter);
    const words = inOtherWords(parameter);
    const normalized = absent(parameter.value) ? "n/a"
      : absent(parameter.normalized) ? "\u2013" : fixed(parameter.normalized, 3) + normalizedUnit(parameter);
    return element("tr", {},
      nameCell(parameter),
      element("td", { class: "number value" }, valueOf(parameter), words && element("small", {}, words)),
      sure ? cell("90 %", between(parameter.interval90, decimals)) : null,
      known ? cell("True", fixed(parameter.true, decimals)) : null,
      cell("/ (m g h)", normalized), rangeCell(parameter));
  });
  const { mgh, mass_kg, com_height_m } = recording.protocol;
  return element("div", { class: "scroll" }, element("table", { class: "answer" },
    element("caption", {}, `m g h = ${compact(mgh)} N m/rad is the torque of gravity per angle of a body of ` +
      `${compact(mass_kg)} kg above the ankles, its centre of mass at ${compact(com_height_m)} m` +
      (recording.body_assumed ? ", which is assumed: only values over m g h hold for another body of that height. " : ". ") +
      "The range is that of the data the model was trained on; dark within it the 90 % interval" +
      (known ? "; the upright red line is the true value." : ".")),
    element("thead", {}, head), element("tbody", {}, ...rows)));
}

// ---- how sure the network is ---------------------------------------------------------------------------------------

function correlationTable({ parameters, correlations }) {
  const cell = value => {
    const made = element("td", {}, fixed(value, 2));
    made.style.background = `rgb(23 82 127 / ${(0.5 * Math.abs(value)).toFixed(2)})`;
    return made;
  };
  return element("div", { class: "scroll" }, element("table", { class: "correlations" },
    element("caption", {}, "Correlations: which errors go together. Near 1 or \u22121 one of the two can make up for the other, and the " +
      "recording fixes their combination better than either."),
    element("thead", {}, element("tr", {}, element("th", { scope: "col" }, ""),
      ...parameters.slice(0, -1).map(({ name }) => element("th", { scope: "col", class: "number" }, name)))),
    element("tbody", {}, ...parameters.slice(1).map(({ name }, row) => element("tr", {},
      element("th", { scope: "row" }, name), ...correlations[row + 1].map(cell))))));
}

function certainty(recording) {
  return [densityFigure("How sure the network is", recording.parameters, recording.densities,
    "that the network gives", report.model.recalibrated
      ? " The intervals are corrected by what trials that the network was not trained on have shown."
      : " No trials beyond its training have shown whether it keeps what it promises."), correlationTable(recording)];
}

// ---- sway ----------------------------------------------------------------------------------------------------------

// What was written as steps from one value to the next.
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
  const points = (list, origin, scale) => list.map((value, k) => ({ x: k / rate, y: value === null ? NaN : (value - origin) / scale }));
  return { sway: points(sway, mean(sway), per_degree), fitted: points(fitted, mean(fitted), per_degree),
    tilt: points(summed(platform.tilt), 0, platform.per_degree) };
}

function swayChart(points, label, from, to) {
  const canvas = element("canvas", { role: "img", "aria-label": label });
  const holder = element("div", { class: "chart" }, canvas);
  const line = (name, key, width) => ({ label: name, data: points[key], borderColor: colours[key],
    backgroundColor: colours[key], borderWidth: width, pointRadius: 0, pointHitRadius: 6 });
  const start = () => {
    const chart = new Chart(canvas, {
      type: "line",
      data: { datasets: [line("Recorded sway", "sway", 1.6), line("Re-simulated sway", "fitted", 1.6), line("Platform tilt", "tilt", 1.2)] },
      options: {
        animation: false, normalized: true, parsing: false, responsive: true, maintainAspectRatio: false,
        interaction: { mode: "nearest", axis: "x", intersect: false },
        scales: { x: { ...axis("Time (s)"), min: from, max: to }, y: axis("Angle (deg)") },
        plugins: {
          decimation: { enabled: true, algorithm: "min-max" },
          legend: { position: "top", align: "end", labels: { usePointStyle: true, pointStyle: "line", color: "#1c2733" } },
          tooltip: { callbacks: { title: items => items.length ? `${items[0].parsed.x.toFixed(2)} s` : "",
            label: item => `${item.dataset.label}: ${fixed(item.parsed.y, 3)} deg` } },
        },
      },
    });
    checks.push(() => Object.keys(points).every(key => {
      const seen = points[key].some(({ x, y }) => x >= chart.scales.x.min && x <= chart.scales.x.max && !Number.isNaN(y));
      return !seen || hasColour(canvas, colours[key]);
    }));
    return chart;
  };
  return { holder, start };
}

function windowFigure(recording, points, end) {
  const { cycles, cycle_s, lead_in_s } = recording.protocol;
  const length = element("select", { "aria-label": "Length of the window" });
  for (const [text, seconds] of [["5 s", 5], ["10 s", 10], ["20 s", 20], ["one stimulus cycle", cycle_s]]) {
    if (seconds < end) length.append(element("option", { value: seconds }, text));
  }
  if (length.options.length === 0) return null;
  length.selectedIndex = Math.min(2, length.options.length - 1);
  const slider = element("input", { type: "range", min: 0, step: 0.5, "aria-label": "Start of the window in seconds" });
  const shown = element("output");
  // The last cycle, when the start has died away; the beginning, if the fit ended before that.
  const last = Math.min(lead_in_s + (cycles - 1) * cycle_s, end - Number(length.value));
  const first = points.fitted.length > 0 && points.fitted.at(-1).x < last ? 0 : last;
  const { holder, start } = swayChart(points, "Line chart: a part of the recorded sway, the re-simulated sway and the platform tilt",
    first, first + Number(length.value));
  const put = chart => {
    slider.max = Math.max(0, end - Number(length.value));
    const from = Number(slider.value), to = from + Number(length.value);
    shown.textContent = `${fixed(from, 1)} to ${fixed(to, 1)} s`;
    if (chart) Object.assign(chart.options.scales.x, { min: from, max: to }), chart.update("none");
  };
  slider.max = end;
  slider.value = first;
  put(null);
  const made = element("figure", { class: "closer" }, element("h3", {}, "A closer look"),
    element("div", { class: "window-controls" }, element("label", {}, "Show ", length), element("label", {}, "from ", slider)), holder,
    element("figcaption", {}, "Shown: ", shown));
  return { made, start: () => {
    const chart = start();
    for (const control of [length, slider]) control.addEventListener("input", () => put(chart));
    put(chart);
  } };
}

// ---- images --------------------------------------------------------------------------------------------------------

const palettes = {  // viridis, red-blue, and a wheel that ends where it begins
  sequential: ["#440154", "#482878", "#3e4a89", "#31688e", "#26828e", "#1f9e89", "#35b779", "#6ece58", "#b5de2b", "#fde725"],
  diverging: ["#2166ac", "#67a9cf", "#d1e5f0", "#f7f7f7", "#fddbc7", "#ef8a62", "#b2182b"],
  cyclic: ["#e2d9e2", "#91b1c8", "#5f6fb9", "#4b2a83", "#2f1436", "#6b1d4b", "#ab4b50", "#cb9a84", "#e2d9e2"],
};

function colourTable(kind) {
  const stops = palettes[kind].map(rgb);
  return Array.from({ length: 256 }, (_, level) => {
    const place = level / 255 * (stops.length - 1);
    const below = Math.min(Math.floor(place), stops.length - 2);
    return stops[below].map((value, channel) => Math.round(value + (place - below) * (stops[below + 1][channel] - value)));
  });
}

function bitmap(width, height, colourAt) {
  const canvas = element("canvas", { width, height });
  const context = canvas.getContext("2d");
  const pixels = context.createImageData(width, height);
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) pixels.data.set([...(colourAt(x, y) ?? [255, 255, 255]), 255], 4 * (y * width + x));
  }
  context.putImageData(pixels, 0, 0);
  return canvas;
}

const channelTitles = {
  modulus: "Modulus", log_modulus: "Logarithm of the modulus", phase: "Phase", cos_phase: "Cosine of the phase",
  sin_phase: "Sine of the phase", real: "Real part", imaginary: "Imaginary part", asinh_real: "Real part, asinh",
  asinh_imaginary: "Imaginary part, asinh", log_residual: "Logarithm of the difference between cycles",
};
const channelUnits = { modulus: "rad", log_modulus: "ln rad", phase: "rad", real: "rad", imaginary: "rad", log_residual: "ln rad" };

function steps(limit, wanted) {
  const rough = limit / wanted, power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find(factor => factor * power >= rough);
  return Array.from({ length: Math.floor(limit / step + 1e-9) + 1 }, (_, i) => Number((i * step).toPrecision(12)));
}

const timeLabel = image => image.fold > 1
  ? "Time in the cycle (s)"
  : image.start_s > 0 ? `Time after ${compact(image.start_s)} s (s)` : "Time (s)";

function drawHeatmap(canvas, image, channel, map, bar) {
  const ratio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const pen = canvas.getContext("2d");
  pen.scale(ratio, ratio);
  pen.imageSmoothingEnabled = false;
  pen.font = "12px system-ui, 'Liberation Sans', sans-serif";
  pen.fillStyle = pen.strokeStyle = "#3d4853";
  const left = 52, top = 8, right = width - 92, bottom = height - 42;
  pen.drawImage(map, left, top, right - left, bottom - top);
  pen.strokeRect(left, top, right - left, bottom - top);

  const duration = image.columns * image.column_s, highest = image.rows * image.row_hz;
  pen.textAlign = "center";
  for (const time of steps(duration, Math.max(2, (right - left) / 70))) {
    const x = left + time / duration * (right - left);
    pen.fillRect(x, bottom, 1, 4);
    pen.fillText(compact(time), x, bottom + 17);
  }
  pen.fillText(timeLabel(image), (left + right) / 2, height - 6);
  pen.textAlign = "right";
  for (const frequency of steps((image.rows - 1) * image.row_hz, 6)) {
    const y = bottom - (frequency + image.row_hz / 2) / highest * (bottom - top);
    pen.fillRect(left - 4, y, 4, 1);
    pen.fillText(compact(frequency), left - 7, y + 4);
  }
  pen.save();
  pen.translate(13, (top + bottom) / 2);
  pen.rotate(-Math.PI / 2);
  pen.textAlign = "center";
  pen.fillText("Frequency (Hz)", 0, 0);
  pen.restore();

  const at = right + 14;
  pen.drawImage(bar, at, top, 14, bottom - top);
  pen.strokeRect(at, top, 14, bottom - top);
  pen.textAlign = "left";
  const limit = value => absent(value) ? "n/a" : channel.logarithmic ? (10 ** value).toExponential(0).replace("e+0", "").replace("e-", "e\u2212") : compact(value);
  pen.fillText(limit(channel.high), at + 19, top + 10);
  pen.fillText(limit((channel.low + channel.high) / 2), at + 19, (top + bottom) / 2 + 4);
  pen.fillText(limit(channel.low), at + 19, bottom);
  pen.fillText(channelUnits[channel.name] ?? "", at, bottom + 17);
  return [left + 1, top + 1, right - left - 2, bottom - top - 2].map(length => Math.round(length * ratio));
}

function heatmap(image, channel) {
  const colour = colourTable(channel.kind);
  const level = (x, y) => channel.levels[(image.rows - 1 - y) * image.columns + x];  // low frequencies below
  const map = bitmap(image.columns, image.rows, (x, y) => colour[level(x, y)]);
  const bar = bitmap(1, 256, (x, y) => colour[255 - y]);
  const title = (channelTitles[channel.name] ?? channel.name) + (channel.logarithmic ? ", logarithmic colours" : "");
  const canvas = element("canvas", { role: "img", "aria-label":
    `Heat map: ${title} of the sway\u2019s spectrum, ${timeLabel(image)} 0 to ${compact(image.columns * image.column_s)} s across, ` +
    `frequency 0 to ${compact((image.rows - 1) * image.row_hz)} Hz upwards` });
  let drawn = [0, 0, 1, 1];
  redraws.push(() => { drawn = drawHeatmap(canvas, image, channel, map, bar); });
  checks.push(() => {
    const { data } = pixelsOf(canvas).getImageData(...drawn);
    const seen = new Set();
    for (let at = 0; at < data.length; at += 4) if (data[at + 3] === 255) seen.add(data[at] << 16 | data[at + 1] << 8 | data[at + 2]);
    return seen.size >= Math.min(10, new Set(channel.levels).size);
  });
  return element("div", {}, element("h4", {}, title), canvas);
}

function imageFigure(image) {
  return element("details", { class: "help" }, element("summary", {}, "What the network saw (for those who train networks)"), element("figure", {},
    element("div", { class: "heatmaps" }, ...image.channels.map(channel => heatmap(image, channel))),
    element("figcaption", {}, `Spectrum of each ${compact(image.column_s)} s of sway, one column a window. ` +
      (image.fold > 1 ? `The ${image.fold} equal cycles of the stimulus are averaged into one. ` : "") +
      (image.mirrored ? "Rows above half the sample rate mirror these and are left out. " : "") +
      "Values beyond a colour scale take its last colour. These pictures are the network\u2019s input, not a result.")));
}

// ---- the page ------------------------------------------------------------------------------------------------------

function fill(made, recording) {
  made.append(trustBox(recording));
  made.append(element("h3", {}, "Identified parameters"), parameterTable(recording),
    element("p", { class: "about" }, (recording.column ? `Sway from column \u201c${recording.column}\u201d. ` : "") + describeProtocol(recording.protocol) + describeTilt(recording.tilt)),
    howToRead("The network\u2019s best estimate, and how far off it usually is."));
  if (isSure(recording)) made.append(...certainty(recording));
  made.append(element("dl", { class: "figures" },
    figure("Sway, peak to peak", absent(recording.peak_to_peak_deg) ? "n/a" : fixed(recording.peak_to_peak_deg, 2) + " deg", "of the recording"),
    figure("Variance accounted for", percent(recording.variance_accounted_for), "of the recording, by the re-simulated sway"),
    figure("Residual, rms", absent(recording.rms_residual_deg) ? "n/a" : fixed(recording.rms_residual_deg, 3) + " deg", "recorded minus re-simulated")));

  const { sway, fitted } = recording.series;
  if (sway.length > 1) {
    const end = (sway.length - 1) / recording.protocol.sample_rate_hz;
    const points = swayPoints(recording);
    const whole = swayChart(points, `Line chart over ${compact(end)} s: recorded sway, ` +
      `${fixed(recording.peak_to_peak_deg, 2)} deg peak to peak, re-simulated sway and platform tilt`, 0, end);
    const fell = fitted.length < sway.length
      ? ` The body re-simulated from these parameters left the model\u2019s limits ${fixed(fitted.length / recording.protocol.sample_rate_hz, 1)} s into the trial, so its line ends there.` : "";
    made.append(element("figure", {}, element("h3", {}, "Recorded and re-simulated sway"), whole.holder,
      element("figcaption", {}, "Both sways are drawn about their means. The re-simulated sway comes from the identified " +
        "parameters without noise: it cannot follow the random part of the recording, so a low variance accounted for " +
        "goes with a high noise gain Nv, too." + fell)));
    whole.start();
    const close = windowFigure(recording, points, end);
    if (close) {
      made.append(close.made);
      close.start();
    }
  }
  const response = frfFigure(recording);
  if (response) {
    made.append(response.made);
    response.start();
  }
  if (recording.image) {
    const saw = imageFigure(recording.image);
    made.append(saw);
    saw.addEventListener("toggle", redraw);
  }
}

function footer() {
  const { name, sha256, version, options, protocol } = report.model;
  document.getElementById("footer").append(
    ...otherAnswer(),
    element("p", {}, element("strong", {}, "This is not a diagnosis. "),
      "The numbers are a neural network\u2019s estimates of the parameters of a simplified model of posture control " +
      "(a single inverted pendulum under disturbance estimation and compensation, DEC). They describe the recording " +
      "as that model sees it, hold for the stated protocol only, and carry the errors of model, network and measurement."),
    element("p", {}, "decid ", version, ", model \u201c", name, "\u201d, SHA-256 of its weights ", element("code", {}, sha256),
      ", protocol \u201c", protocol, "\u201d", ...(options.length > 0 ? [", options ", element("code", {}, options.join(" "))] : []), "."));
}

if (report.recordings.length === 1) document.title = `${report.recordings[0].file} \u2013 posture control report`;
contents(valueOf,
  ["Explained", recording => percent(recording.variance_accounted_for)]);
failures("Not identified");
sections(fill);
footer();
finish();
})();
