// Draws the report of decid fit, after common.js, plot.js, recordings.js and density.js.
(() => {
// ---- the parameters ------------------------------------------------------------------------------------------------

// A value between limits that are so far apart.
const within = (value, span) => fixed(value, Math.min(12, Math.max(0, Math.ceil(1 - Math.log10(span)))));

// Quantities that are not the controller's, which the posterior averages over.
function othersTable({ others }) {
  const rows = others.map(other => {
    const decimals = Math.max(0, Math.floor(1.5 - Math.log10(other.sd)));
    return element("tr", {}, element("th", { scope: "row" }, other.name), element("td", { class: "number" }, `${fixed(other.mean, decimals)} \u00b1 ${fixed(other.sd, decimals)} ${unitOf(other)}`),
      element("td", { class: "number" }, `${between(other.interval90, decimals)} ${unitOf(other)}`));
  });
  return rows.length === 0 ? null : element("div", { class: "scroll" }, element("table", {},
    element("thead", {}, element("tr", {}, columnHead("Also inferred", "", ""), columnHead("Estimate \u00b1 uncertainty", "1 SD"), columnHead("90% interval"))),
    element("tbody", {}, ...rows)));
}

function partsOf(recording, p) {
  const { values, range } = recording.draws, parameter = recording.parameters[p];
  const low = placeIn(parameter, parameter.factor * recording.draws.low[p]), high = placeIn(parameter, parameter.factor * recording.draws.high[p]);
  return values[p].map(value => low + (high - low) * value / range);
}

// A kernel estimate of the density on 0 to 1, mirrored at both ends: [place, density], the prior being 1.
function densityOf(parts) {
  const sorted = [...parts].sort((a, b) => a - b), count = sorted.length;
  const at = share => sorted[Math.round(share * (count - 1))];
  const mean = sorted.reduce((sum, value) => sum + value, 0) / count;
  const deviation = Math.sqrt(sorted.reduce((sum, value) => sum + (value - mean) ** 2, 0) / count);
  const width = Math.max(0.9 * Math.min(deviation, (at(0.75) - at(0.25)) / 1.34 || deviation) * count ** -0.2, 1e-7);
  const low = Math.max(0, sorted[0] - 4 * width), high = Math.min(1, sorted[count - 1] + 4 * width);
  const places = [...Array.from({ length: 41 }, (_, i) => i / 40), ...Array.from({ length: 161 }, (_, i) => low + (high - low) * i / 160)];
  const kernel = z => z * z < 40 ? Math.exp(-0.5 * z * z) : 0;
  return places.sort((a, b) => a - b).map(x => [x, sorted.reduce((sum, value) =>
    sum + kernel((x - value) / width) + kernel((x + value) / width) + kernel((2 - x - value) / width), 0) /
    (count * width * Math.sqrt(2 * Math.PI))]);
}

function densities(recording) {
  return densityFigure("Certainty of each estimate", recording.parameters,
    recording.parameters.map((_, p) => densityOf(partsOf(recording, p))), "");
}

// ---- pairs ---------------------------------------------------------------------------------------------------------

function pairs(recording) {
  const { parameters, correlations } = recording, count = parameters.length, cell = 104, left = 54, top = 6, gap = 6;
  const all = parameters.map((_, p) => partsOf(recording, p));
  const limits = all.map((parts, p) => {
    const known = "true" in parameters[p] ? [placeIn(parameters[p], parameters[p].true)] : [];
    const low = Math.min(...parts, ...known), high = Math.max(...parts, ...known), margin = 0.05 * (high - low) || 1e-6;
    return [low - margin, high + margin];
  });
  const begin = i => i * cell + gap / 2, size = cell - gap;
  const along = (p, part) => begin(p) + left + size * (part - limits[p][0]) / (limits[p][1] - limits[p][0]);
  const up = (p, part) => top + begin(p) + size * (limits[p][1] - part) / (limits[p][1] - limits[p][0]);
  const value = (p, part) => parameters[p].low + part * (parameters[p].high - parameters[p].low);
  const children = [];
  for (let row = 0; row < count; ++row) {
    for (let column = 0; column < count; ++column) {
      const x = left + begin(column), y = top + begin(row);
      if (column > row) {
        const found = correlations[column][row];
        children.push(shape("rect", { x, y, width: size, height: size, class: "cell", "fill-opacity": (0.5 * Math.abs(found)).toFixed(2) }),
          label(x + size / 2, y + size / 2 + 4, fixed(found, 2), "middle name"));
        continue;
      }
      children.push(shape("rect", { x, y, width: size, height: size, class: "frame" }));
      const known = p => "true" in parameters[p];
      const truth = p => placeIn(parameters[p], parameters[p].true);
      if (known(column)) children.push(line(along(column, truth(column)), y, along(column, truth(column)), y + size, "truth"));
      if (column === row) {
        const density = densityOf(all[row]).filter(([part]) => part > limits[row][0] && part < limits[row][1]);
        const highest = Math.max(...density.map(([, at]) => at));
        children.push(path(density.map(([part, at]) => [along(row, part), y + size - 0.72 * size * at / highest]), "draw"),
          label(x + 5, y + 14, parameters[row].name, "name"));
      } else {
        if (known(row)) children.push(line(x, up(row, truth(row)), x + size, up(row, truth(row)), "truth"));
        children.push(shape("path", { class: "dots",
          d: all[column].map((part, i) => `M${short(along(column, part))} ${short(up(row, all[row][i]))}h.01`).join("") }));
      }
    }
    const span = (limits[row][1] - limits[row][0]) * (parameters[row].high - parameters[row].low);
    limits[row].forEach((part, last) => {
      children.push(label(left + begin(row) + size * last, top + count * cell + 12, within(value(row, part), span), last ? "end" : ""));
      if (row > 0) children.push(label(left - 2, top + begin(row) + (last ? 10 : size), within(value(row, part), span), "end"));
    });
  }
  return element("figure", {}, element("h3", {}, "Which estimates depend on each other"),
    element("div", { class: "scroll pairs" }, drawing(left + count * cell + 4, top + count * cell + 20,
      "Pairs of parameters: draws below the diagonal, correlations above it", children)),
    element("figcaption", {}, "Below the diagonal: draws of two parameters; above: their correlation. In a narrow sloping cloud one parameter can replace " +
      "the other: the recording determines their combination better than either. Each axis spans the draws, not the model\u2019s limits."));
}

// ---- over time -----------------------------------------------------------------------------------------------------

// signal: one of the recording's; parts: [name, class, values] of lines, [name, class, low, high] of bands; levels: [value, class, name].
function timeline(title, signal, unit, parts, levels, caption) {
  const point = (values, i) => values[i] === null ? NaN : values[i] / signal.per_degree;
  const points = (values, others) => values.map((_, i) => [signal.first_s + i * signal.step_s, point(values, i), ...(others ? [point(others, i)] : [])]);
  const shown = parts.filter(([, , values]) => values), end = signal.first_s + (shown[0][2].length - 1) * signal.step_s;
  const { made, draw } = plot({ title, x: { text: "Time (s)", low: 0, high: end }, y: { text: unit }, height: 250,
    marks: [...shown.map(([name, kind, values, others]) => ({ name, class: kind, [others ? "band" : "line"]: points(values, others) })),
      ...levels.map(([level, kind, name]) => ({ name, class: kind, level }))] });
  return { made: element("div", { class: "timeline" }, element("h4", {}, title), made, element("p", { class: "note" }, caption)), draw, end };
}

function timelines(recording) {
  const { sway, noise, tilt } = recording.signals;
  const theta = recording.parameters.find(parameter => parameter.name === "theta");
  const dead = theta ? theta.mean : null;
  const again = sway.again_low ? [["90% of new simulated trials", "again-soft", sway.again_low, sway.again_high]] : [];
  const charts = [
    timeline("Measured sway and the model\u2019s sway", sway, "Sway (\u00b0)",
      [...again, ["Model with the inferred noise: 90% interval", "soft", sway.model_low, sway.model_high],
        ["Median", "draw", sway.model_middle], ["Measured", "recorded", sway.recorded]], [],
      "All about their means; each point is the mean of " + compact(1000 * sway.step_s) + " ms. Narrow band: the model\u2019s sway with the sensory noise " +
      "inferred from this recording; the measured sway should run within it. Wide band: trials with other noise, as on another day; the " +
      "measured sway should look like one of them."),
    timeline("Hidden signal: sensory noise", noise, "Velocity (\u00b0/s)",
      [["90% interval", "soft", noise.noise_low, noise.noise_high], ["Median", "draw", noise.noise_middle]],
      dead ? [[dead, "edge", "Tilt-speed threshold"], [-dead, "edge"]] : [],
      "Not measured: the noise of the sense of balance, as an angular velocity, with which the model sways as measured. Where platform velocity " +
      "and noise together stay below the threshold, the controller perceives nothing; there the band is wider."),
    timeline("Hidden signal: perceived platform tilt", tilt, "Tilt (\u00b0)",
      [["90% interval", "soft", tilt.estimate_low, tilt.estimate_high], ["Median", "draw", tilt.estimate_middle], ["Platform tilt", "tilt", tilt.platform]], [],
      "Not measured: the tilt that the model\u2019s controller perceives. It lacks the movement below the threshold, and drifts with the noise. " +
      "decid ignores slow drift, so the level of this signal is less certain than its shape."),
  ];
  const end = Math.max(...charts.map(chart => chart.end));
  const choices = [["the whole trial", end], ...[60, 30, 15].filter(seconds => seconds < end).map(seconds => [`${seconds} s`, seconds])];
  return element("figure", {}, element("h3", {}, "Measured sway and the model\u2019s hidden signals"),
    windowControls(choices, 0, 0, end, (from, to) => charts.forEach(chart => chart.draw(from, to))), ...charts.map(chart => chart.made));
}

// ---- checks --------------------------------------------------------------------------------------------------------

const oddBelow = 0.01;
const isOdd = recording => recording.check.figures.some(({ p }) => p < oddBelow);

function placeCell({ low, high, middle, recorded }) {
  const ends = [Math.min(low, recorded), Math.max(high, recorded)], span = ends[1] - ends[0] || 1, width = 160;
  const x = value => 8 + (width - 16) * (value - ends[0]) / span;
  return element("td", { class: "place" }, shape("svg", { viewBox: `0 0 ${width} 18`, "aria-hidden": "true" },
    line(x(low), 9, x(high), 9, "ninety"), line(x(middle), 3, x(middle), 15, "draw"),
    shape("circle", { cx: short(x(recorded)), cy: 9, r: 4.5, class: "mean" })));
}

function checkTable(recording) {
  const { figures, trials, standing } = recording.check;
  if (figures.length === 0) return element("p", { class: "note" }, `Only ${standing} of ${trials} simulated trials stand: too few to compare with the recording.`);
  const name = figure => figure.name.endsWith("Hz") ? `Sway at ${figure.name}, rms` : figure.name === "between cycles" ? "Standard deviation between cycles"
    : figure.name === "level" ? "Level, rms" : figure.name === "frequency response" ? "Frequency response, distance" : "Largest sway";
  const heading = (text, kind = "number") => element("th", { scope: "col", class: kind }, text);
  const unit = figure => unitOf(figure);
  return element("div", {}, element("p", { class: "note" }, `Compared with ${standing} trials simulated from the posterior, each with new sensory and measurement noise. p is a Monte Carlo p-value, two-sided except for the frequency response. ` +
      `Values below ${oddBelow} are marked; at most one in a hundred is so by chance. The distance of the frequency response is squared, over the trials\u2019 variance: 1 is usual.`), element("div", { class: "scroll" }, element("table", {},
    element("thead", {}, element("tr", {}, heading("Property of the sway", ""), heading("Measured"), heading("90% of simulated trials"), heading("Measured (ring) among simulated", ""), heading("p"))),
    element("tbody", {}, ...figures.map(figure => element("tr", {}, element("th", { scope: "row" }, name(figure)),
      element("td", { class: "number" }, compact(figure.recorded) + unit(figure)),
      element("td", { class: "number" }, `${compact(figure.low)} to ${compact(figure.high)}${unit(figure)}`), placeCell(figure),
      element("td", { class: figure.p < oddBelow ? "number odd" : "number" }, fixed(figure.p, 3))))))));
}

function diagnosis(recording) {
  const { agreed, chains, draws, rhat, effective_draws, divergences, energy_fraction, restarts } = recording.diagnostics;
  const { value, standard_error, effective_parameters, unreliable, blocks, block_s } = recording.log_density;
  const noise = recording.others.find(other => other.unit === "deg"), samples = recording.samples_noise_deg;
  const items = [
    agreed ? `The ${chains} chains, which began in different places, agree: R-hat is at most ${fixed(rhat, 3)} (1 is perfect). Agreement means at most 1.05, with 100 effective draws of every quantity.`
      : !recording.warnings.some(({ code }) => code === "chains_disagree")
        ? `The ${chains} chains agree roughly: R-hat is up to ${fixed(rhat, 2)} (1.05 would be agreement), and a quantity has ${compact(effective_draws)} effective draws (100 would be enough). Ends of intervals are less certain.`
        : `The ${chains} chains do not agree: R-hat is up to ${fixed(rhat, 2)} (limit 1.05), and a quantity has only ${compact(effective_draws)} effective draws (100 are enough). More than one controller may fit this recording; do not rely on these values.`,
    `${draws} draws, with at least ${compact(effective_draws)} effective draws of every quantity.`,
    divergences === 0 ? "No divergent transition." : `${divergences} divergent transition${divergences === 1 ? "" : "s"}: corners of the posterior may be missing.`,
    energy_fraction < 0.3 ? `The energy fraction is ${fixed(energy_fraction, 2)}, below 0.3: tails of the posterior may be missing.` : null,
    restarts > 0 ? `${restarts} chain${restarts === 1 ? " was" : "s were"} stuck while warming up and continued from the place of another chain.` : null,
    noise ? `The model leaves ${compact(noise.mean)}\u00b0 of sway per sample unexplained. The measurement noise, from the power above 2 Hz, is ${compact(samples)}\u00b0.` +
      (noise.mean > 3 * Math.max(samples, 1e-3) ? " The unexplained sway is far larger: the intervals treat it as noise." : "") : null,
    `Log predictive density (leave-one-out): ${compactSum(value)} \u00b1 ${compact(standard_error)} nats for ${blocks} means of ${compact(1000 * block_s)} ms, in degrees, with ` +
      `${compact(effective_parameters)} effective parameters` + (unreliable > 0 ? `; ${unreliable} of the ${blocks} rest on few draws.` : "."),
  ].filter(text => text !== null);
  return element("ul", { class: "plain" }, ...items.map(text => element("li", {}, text)));
}
const compactSum = value => absent(value) ? "n/a" : fixed(value, 0);

// ---- chains --------------------------------------------------------------------------------------------------------

function tracePanel(parameter, parts, { chains, each, every }) {
  const width = 640, height = 110, left = 56, right = width - 4, top = 4, bottom = height - 18;
  const low = Math.min(...parts), high = Math.max(...parts), span = high - low || 1, size = span * (parameter.high - parameter.low);
  const y = part => bottom - (bottom - top) * (part - low) / span, x = i => left + (right - left) * i / Math.max(1, each - 1);
  const value = part => parameter.low + part * (parameter.high - parameter.low);
  const children = Array.from({ length: chains }, (_, chain) => {
    const made = path(Array.from({ length: each }, (_, i) => [x(i), y(parts[chain * each + i])]), "chain");
    made.style.stroke = `hsl(${Math.round(360 * chain / chains)} 60% 50%)`;
    made.style.strokeWidth = "0.8";
    return made;
  });
  children.push(label(left - 5, top + 9, within(value(high), size), "end"), label(left - 5, bottom, within(value(low), size), "end"),
    label(left, height - 4, "1"), label(right, height - 4, `draw ${each * every}`, "end"),
    shape("rect", { x: left, y: top, width: right - left, height: bottom - top, class: "frame" }));
  return drawing(width, height, `Traces of ${parameter.description}: ${chains} chains of ${each * every} draws`, children);
}

function rankPanel(parameter, counts) {
  const width = 320, height = 110, left = 4, top = 4, bins = counts[0].length;
  const expected = counts[0].reduce((sum, count) => sum + count, 0) / bins;
  const w = (width - 2 * left) / bins, h = (height - top - 18) / counts.length;
  const children = counts.flatMap((row, chain) => row.map((count, bin) => shape("rect", { x: short(left + bin * w), y: short(top + chain * h),
    width: short(w - 0.5), height: short(h - 0.5), class: "cell", "fill-opacity": Math.min(1, count / (2.5 * expected)).toFixed(2) })));
  children.push(label(left, height - 4, "lowest draws"), label(width - left, height - 4, "highest", "end"));
  return drawing(width, height, `Rank plot of ${parameter.description}, one row per chain`, children);
}

function chainsFold(recording) {
  const made = element("details", { class: "help" }, element("summary", {}, "Details of the calculation"), diagnosis(recording), othersTable(recording),
    element("p", { class: "note" }, "Left: the draws of each chain, one colour per chain. They should look like one thick band without steps. Right: one row per chain, from the lowest " +
      "tenth of all draws to the highest. The stronger the colour, the more of the chain\u2019s draws are there; good rows are evenly coloured."),
    element("div", { class: "mixing" }, ...recording.parameters.flatMap((parameter, p) => [
      element("div", {}, element("h4", {}, parameter.description, " ", element("small", {}, `R-hat ${fixed(parameter.rhat, 3)}, ${compact(parameter.effective_draws)} effective draws`)),
        tracePanel(parameter, partsOf(recording, p), recording.draws)),
      element("div", {}, element("h4", {}, "\u00a0"), rankPanel(parameter, recording.ranks[p]))])));
  return made;
}

// ---- the page ------------------------------------------------------------------------------------------------------

function fill(made, recording) {
  const { agreed, rhat } = recording.diagnostics, tested = recording.check.figures.length > 0;
  const smallest = Math.min(1, ...recording.check.figures.map(({ p }) => p));
  made.append(trustBox(recording), element("h3", {}, "Estimates"), parameterTable(recording, recording.answer === "network"), nextSteps(recording), ...aboutRecording(recording),
    howToRead("The mean of all controllers that sway as measured, each weighted by its probability."),
    element("dl", { class: "figures" },
      figure("Calculation converged", agreed ? "yes" : "no", `R-hat at most ${fixed(rhat, 3)}; 1 is perfect`),
      figure("Simulated sway resembles the recording", !tested ? "unknown" : isOdd(recording) ? "no" : "yes",
        tested ? `smallest p ${fixed(smallest, 3)}` : "too few simulated bodies stand"),
      figure("Sway, peak to peak", inDegrees(recording.peak_to_peak_deg, 2), "of the recording")),
    ...[controllersSection(recording)].filter(section => section !== null),
    densities(recording), timelines(recording), pairs(recording),
    element("h3", {}, "Does simulated sway resemble the recording?"), checkTable(recording), chainsFold(recording));
}

function footer() {
  document.getElementById("footer").append(
    element("p", {}, element("strong", {}, "This is not a diagnosis. "),
      "The intervals hold if a simplified model of posture control is right: a single inverted pendulum under disturbance estimation " +
      "and compensation (DEC). They hold for the stated protocol and body only."),
    element("p", {}, `decid ${report.version}, seed ${report.seed}. Charts show up to ${shownDraws} draws; figures come from all draws.`),
    ...callTexts(report.call));
}
const shownDraws = 800;

if (report.recordings.length === 1) document.title = `${report.recordings[0].file} \u2013 detailed analysis of balance control`;
contents(parameter => valueOf(parameter, parameter.mean),
  ["R\u2011hat", recording => fixed(recording.diagnostics.rhat, 2)]);
failures("Not analysed");
sections(fill);
footer();
finish();
})();
