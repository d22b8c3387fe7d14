// Draws the report of decid fit, after common.js, plot.js, recordings.js and density.js.
(() => {
// ---- the parameters ------------------------------------------------------------------------------------------------

// A value between limits that are so far apart.
const within = (value, span) => fixed(value, Math.min(12, Math.max(0, Math.ceil(1 - Math.log10(span)))));

function parameterTable(recording) {
  const known = recording.parameters.some(parameter => "true" in parameter), network = recording.answer === "network";
  const heading = (text, kind = "number") => element("th", { scope: "col", class: kind }, text);
  const number = text => cell("", text);
  const { mgh } = recording.protocol;
  const rows = recording.parameters.map(parameter => {
    const decimals = finestOf(parameter), words = inOtherWords({ ...parameter, value: parameter.mean });
    const mean = element("td", { class: "number value" }, `${fixed(parameter.mean, decimals)} \u00b1 ${fixed(parameter.sd, decimals)}`,
      words && element("small", {}, words));
    return element("tr", {},
      nameCell(parameter),
      network ? cell("Network", fixed(parameter.value, decimals)) : null, mean, cell("50 %", between(parameter.interval50, decimals)),
      cell("90 %", between(parameter.interval90, decimals)), known ? cell("True", fixed(parameter.true, decimals)) : null,
      cell("90 % / (m g h)", absent(parameter.normalized) ? "\u2013" : between(parameter.interval90.map(value => value / mgh), 3) + normalizedUnit(parameter)));
  });
  for (const other of recording.others) {
    const decimals = Math.max(0, Math.floor(1.5 - Math.log10(other.sd)));
    rows.push(element("tr", {}, element("th", { scope: "row" }, other.name, unitOf(other) && element("span", { class: "description" }, unitOf(other))), network ? number("") : null,
      element("td", { class: "number value" }, `${fixed(other.mean, decimals)} \u00b1 ${fixed(other.sd, decimals)}`),
      cell("50 %", between(other.interval50, decimals)), cell("90 %", between(other.interval90, decimals)), known ? number("") : null, number("")));
  }
  const about = "Mean of all draws and their standard deviation; the intervals hold 50 and 90 % of the draws. " +
    `m g h = ${compact(mgh)} N m/rad is the torque of gravity per angle of this body.` +
    (network ? " The chains do not agree, so the answer is the network\u2019s." : "");
  return element("div", { class: "scroll" }, element("table", { class: "answer" }, element("caption", {}, about),
    element("thead", {}, element("tr", {}, heading("Parameter", ""), network ? heading("Network") : null, heading("Mean \u00b1 deviation"),
      heading("50 % of the draws"), heading("90 % of the draws"), known ? heading("True") : null,
      heading("90 %, over m g h"))),
    element("tbody", {}, ...rows)));
}

function partsOf(recording, p) {
  const { values, range } = recording.draws, low = placeIn(recording.parameters[p], recording.draws.low[p]);
  const high = placeIn(recording.parameters[p], recording.draws.high[p]);
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
  return densityFigure("What the recording says of each parameter", recording.parameters,
    recording.parameters.map((_, p) => densityOf(partsOf(recording, p))), "of the draws", "");
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
  return element("figure", {}, element("h3", {}, "Which parameters the recording cannot tell apart"),
    element("div", { class: "scroll pairs" }, drawing(left + count * cell + 4, top + count * cell + 20,
      "Pairs of parameters: draws below the diagonal, correlations above it", children)),
    element("figcaption", {}, "Below the diagonal draws of two parameters, above it their correlation. A narrow slope means that one of the " +
      "two can make up for the other: the recording fixes their combination better than either. Each axis spans the draws, not the range."));
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
  const dead = theta ? theta.mean * 180 / Math.PI : null;
  const again = sway.again_low ? [["Simulated anew: 90 % of the trials", "again-soft", sway.again_low, sway.again_high]] : [];
  const charts = [
    timeline("Sway: recorded, and as the model has it", sway, "Sway (deg)",
      [...again, ["The model with the inferred noise: 90 % of the draws", "soft", sway.model_low, sway.model_high],
        ["Its median", "draw", sway.model_middle], ["Recorded", "recorded", sway.recorded]], [],
      "All about their means, each point the mean of " + compact(1000 * sway.step_s) + " ms. The narrow band is the model\u2019s sway with the vestibular noise " +
      "that was inferred from this recording: it should run within it. The wide band is that of trials with other noise, as the same controller would sway on another day: the " +
      "recording should be one of them."),
    timeline("Inferred: the vestibular noise", noise, "Velocity (deg/s)",
      [["90 % of the draws", "soft", noise.noise_low, noise.noise_high], ["Median", "draw", noise.noise_middle]],
      dead ? [[dead, "edge", "Edges of the dead band (mean theta)"], [-dead, "edge"]] : [],
      "Not measured: what the model needs the noise of the sense of balance to have been, as an angular velocity, to sway as recorded. Where the platform\u2019s velocity " +
      "and the noise together stay within the dead band, the controller perceives nothing and the recording says only that; there the band is wider."),
    timeline("Inferred: the controller\u2019s estimate of the platform\u2019s tilt", tilt, "Tilt (deg)",
      [["90 % of the draws", "soft", tilt.estimate_low, tilt.estimate_high], ["Median", "draw", tilt.estimate_middle], ["The platform\u2019s tilt", "tilt", tilt.platform]], [],
      "Not measured: what passes the dead band, integrated. It is what the model\u2019s controller takes for the platform\u2019s tilt; it falls short of it by what the dead band " +
      "keeps back, and wanders with the noise. Slow drift is no evidence (see the documentation), so its level is known less well than its course."),
  ];
  const end = Math.max(...charts.map(chart => chart.end));
  const choices = [["the whole trial", end], ...[60, 30, 15].filter(seconds => seconds < end).map(seconds => [`${seconds} s`, seconds])];
  return element("figure", {}, element("h3", {}, "What was recorded, and what nobody saw"),
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
  if (figures.length === 0) return element("p", { class: "note" }, `Of ${trials} trials simulated from the draws only ${standing} stand: too few to compare with the recording.`);
  const name = figure => figure.name.endsWith("Hz") ? `Sway at ${figure.name}, rms` : figure.name === "between cycles" ? "Difference between cycles, rms"
    : figure.name === "level" ? "Level, rms" : figure.name === "frequency response" ? "Frequency response, distance" : "Largest sway";
  const heading = (text, kind = "number") => element("th", { scope: "col", class: kind }, text);
  const unit = figure => figure.unit === "1" ? "" : " " + figure.unit;
  return element("div", {}, element("p", { class: "note" }, `${standing} trials simulated from the draws, each with vestibular and sensor noise of its own. p is two-sided: twice the share of trials as ` +
      `low as the recording, or as high, whichever is smaller. Below ${oddBelow} it is marked: one figure in a hundred at most is so by chance. The distance of the ` +
      "frequency response is from the trials\u2019 mean, squared, over their variance: 1 is usual."), element("div", { class: "scroll" }, element("table", {},
    element("thead", {}, element("tr", {}, heading("Figure", ""), heading("Recorded"), heading("90 % of the simulated"), heading("Place (ring: recorded)", ""), heading("p"))),
    element("tbody", {}, ...figures.map(figure => element("tr", {}, element("th", { scope: "row" }, name(figure)),
      element("td", { class: "number" }, compact(figure.recorded) + unit(figure)),
      element("td", { class: "number" }, `${compact(figure.low)} to ${compact(figure.high)}${unit(figure)}`), placeCell(figure),
      element("td", { class: figure.p < oddBelow ? "number odd" : "number" }, fixed(figure.p, 3))))))));
}

function diagnosis(recording) {
  const { agreed, chains, draws, rhat, effective_draws, divergences, energy_fraction, restarts } = recording.diagnostics;
  const { value, standard_error, effective_parameters, unreliable, blocks, block_s } = recording.log_density;
  const noise = recording.others.find(other => other.name === "Sensor noise"), samples = recording.samples_noise_deg;
  const items = [
    agreed ? `The ${chains} chains, which began in different places, say the same: R-hat is ${fixed(rhat, 3)} at most (1 is perfect; up to 1.05, with 100 effective draws of every quantity, counts as agreement).`
      : `The ${chains} chains do not say the same, or not enough: R-hat is up to ${fixed(rhat, 2)} (1.05 and less counts as agreement), the fewest effective draws of a quantity are ${compact(effective_draws)} (100 are enough). More than one controller may fit this recording; do not rely on these values.`,
    `The ${draws} draws are worth ${compact(effective_draws)} independent ones or more.`,
    divergences === 0 ? "No transition ran away." : `${divergences} transition${divergences === 1 ? "" : "s"} ran away (divergences): corners of what is possible may be missing.`,
    energy_fraction < 0.3 ? `The chains cross energies slowly (${fixed(energy_fraction, 2)}, below 0.3): tails may be missing.` : null,
    restarts > 0 ? `${restarts} chain${restarts === 1 ? " was" : "s were"} stuck while warming up and went on from another\u2019s place.` : null,
    noise ? `The model leaves ${compact(noise.mean)} deg of sway unexplained a sample; the sensor\u2019s own noise, by how neighbouring samples differ, is ${compact(samples)} deg.` +
      (noise.mean > 3 * Math.max(samples, 1e-3) ? " That is far more: the intervals take for noise what the model cannot explain." : "") : null,
    `Log predictive density (leave-one-out): ${compactSum(value)} \u00b1 ${compact(standard_error)} nats for ${blocks} means of ${compact(1000 * block_s)} ms in degrees, with ` +
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
  return drawing(width, height, `Traces of ${parameter.name}: ${chains} chains of ${each * every} draws`, children);
}

function rankPanel(parameter, counts) {
  const width = 320, height = 110, left = 4, top = 4, bins = counts[0].length;
  const expected = counts[0].reduce((sum, count) => sum + count, 0) / bins;
  const w = (width - 2 * left) / bins, h = (height - top - 18) / counts.length;
  const children = counts.flatMap((row, chain) => row.map((count, bin) => shape("rect", { x: short(left + bin * w), y: short(top + chain * h),
    width: short(w - 0.5), height: short(h - 0.5), class: "cell", "fill-opacity": Math.min(1, count / (2.5 * expected)).toFixed(2) })));
  children.push(label(left, height - 4, "lowest draws"), label(width - left, height - 4, "highest", "end"));
  return drawing(width, height, `Rank plot of ${parameter.name}, a row a chain`, children);
}

function chainsFold(recording) {
  const made = element("details", {}, element("summary", {}, "Traces and rank plots of the chains"),
    element("p", { class: "note" }, "Left: each chain\u2019s draws, one colour a chain; they should look like one thick hairy line without steps. Right: a row a chain, from the lowest " +
      "tenth of all draws to the highest; the stronger the colour, the more of the chain\u2019s draws are there. Rows that are evenly coloured have seen the same as all others."),
    element("div", { class: "mixing" }, ...recording.parameters.flatMap((parameter, p) => [
      element("div", {}, element("h4", {}, parameter.name, " ", element("small", {}, `R-hat ${fixed(parameter.rhat, 3)}, worth ${compact(parameter.effective_draws)} draws`)),
        tracePanel(parameter, partsOf(recording, p), recording.draws)),
      element("div", {}, element("h4", {}, "\u00a0"), rankPanel(parameter, recording.ranks[p]))])));
  return made;
}

// ---- the page ------------------------------------------------------------------------------------------------------

function fill(made, recording) {
  const { agreed, rhat } = recording.diagnostics, tested = recording.check.figures.length > 0;
  const smallest = Math.min(1, ...recording.check.figures.map(({ p }) => p));
  made.append(trustBox(recording), element("h3", {}, "The parameters"), parameterTable(recording),
    element("p", { class: "about" }, (recording.column ? `Sway from column \u201c${recording.column}\u201d. ` : "") + describeProtocol(recording.protocol) + describeTilt(recording.tilt)),
    howToRead("The mean of the draws: controllers that sway as was recorded, each as often as it is probable."),
    element("dl", { class: "figures" },
      figure("Can it be believed?", agreed ? "chains agree" : "chains disagree", `R-hat ${fixed(rhat, 3)} at most; 1 is perfect`),
      figure("Does the model sway like this?", !tested ? "unknown" : isOdd(recording) ? "no" : "yes",
        tested ? `simulated again, smallest p ${fixed(smallest, 3)}` : "simulated again, the body falls"),
      figure("Sway, peak to peak", absent(recording.peak_to_peak_deg) ? "n/a" : fixed(recording.peak_to_peak_deg, 2) + " deg", "of the recording")),
    densities(recording), timelines(recording), pairs(recording),
    element("h3", {}, "Does sway that is simulated again look like the recording?"), checkTable(recording),
    element("h3", {}, "Whether to believe it"), diagnosis(recording), chainsFold(recording));
}

function footer() {
  document.getElementById("footer").append(
    ...otherAnswer(),
    element("p", {}, element("strong", {}, "This is not a diagnosis. "),
      "The intervals say what the recording tells about the parameters of a simplified model of posture control (a single inverted pendulum under disturbance estimation " +
      "and compensation, DEC), if that model is right. No model is people. They hold for the stated protocol and body only."),
    element("p", {}, `decid ${report.version}, seed ${report.seed}. Up to ${shownDraws} draws are drawn on this page; figures are of all of them.`),
    ...callTexts(report.call));
}
const shownDraws = 800;

if (report.recordings.length === 1) document.title = `${report.recordings[0].file} \u2013 posterior of posture control`;
contents(parameter => `${fixed(parameter.mean, finestOf(parameter))} \u00b1 ${fixed(parameter.sd, finestOf(parameter))}`,
  ["R\u2011hat", recording => fixed(recording.diagnostics.rhat, 2)]);
failures("Not fitted");
sections(fill);
footer();
finish();
})();
