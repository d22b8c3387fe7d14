// Functions that the pages of decid identify and decid fit share, after common.js and parameters.js: text about recordings and their contents.

for (const { parameters } of report.recordings) parameters.forEach(inShownUnit);

// ---- the table of parameters -----------------------------------------------------------------------------------------

// network: the answer is the network's although the parameters have the posterior's means and intervals.
function parameterTable({ parameters, protocol, body_assumed: assumed }, network = false) {
  const known = parameters.some(parameter => "true" in parameter), sure = parameters.some(parameter => "sd" in parameter);
  const rows = parameters.map(parameter => {
    const decimals = finestOf(parameter), value = network ? parameter.mean : parameter.value, overGravity = value => fixed(value / protocol.mgh, 3);
    const relative = absent(parameter.normalized) || absent(value) ? cell("Gravity", "\u2013") : cell("Gravity", overGravity(value) + normalizedUnit(parameter));
    if (sure && !isFixed(parameter) && !absent(parameter.normalized)) relative.append(element("small", {}, parameter.interval90.map(overGravity).join(" to ")));
    return element("tr", {}, nameCell(parameter), element("td", { class: "number value" }, valueOf(parameter, value)),
      network ? cell("Network", fixed(parameter.value, decimals)) : null,
      sure ? cell("90%", intervalOf(parameter)) : null,
      known ? cell("True", fixed(parameter.true, decimals)) : null, relative, rangeCell(parameter, value));
  });
  return element("div", { class: "scroll" }, element("table", { class: "answer" },
    element("caption", {}, `Gravity: m g h = ${compact(protocol.mgh)} N m/rad, for ${compact(protocol.mass_kg)} kg above the ankles with the centre of mass at ` +
      `${compact(protocol.com_height_m)} m. ` + (assumed ? "This body is assumed: values in N m/rad and N m s/rad are not this person\u2019s. " : "") +
      (network ? "The calculation did not converge, so the answer is the network\u2019s. " : "") +
      `Bar: the model\u2019s limits.` + (sure ? " Dark: 90% interval." : "") + (known ? " Red line: true value." : "")),
    element("thead", {}, element("tr", {}, columnHead("Parameter", "", ""), sure ? columnHead("Estimate \u00b1 uncertainty", "1 SD") : columnHead("Estimate"),
      network ? columnHead("Network") : null, sure ? columnHead("90% interval") : null, known ? columnHead("True") : null,
      columnHead("Relative to gravity", sure ? "over m g h; 90%" : "over m g h"),
      columnHead("Estimate within the model\u2019s limits", "not a normal range", ""))),
    element("tbody", {}, ...rows)));
}

// ---- the answer ----------------------------------------------------------------------------------------------------

const describeTilt = tilt => absent(tilt) ? "" : ` Platform movement found at ${fixed(tilt.delay_s, 3)} s ` +
  `(column \u201c${tilt.column}\u201d, correlation ${fixed(tilt.correlation, 3)}, ${tilt.gain === null ? "size unknown (no unit)" : `gain ${fixed(tilt.gain, 3)}`}).`;

// Describes what decid read, with the notes on what it assumed.
function aboutRecording({ column, protocol, tilt, warnings }) {
  const notes = warnings.filter(({ severity }) => severity === "info");
  return [element("h3", {}, "About the recording"), element("p", { class: "about" }, (column ? `Sway from column \u201c${column}\u201d. ` : "") + describeProtocol(protocol) + describeTilt(tilt)),
    ...(notes.length === 0 ? [] : [element("ul", { class: "about notes" }, ...notes.map(({ text }) => element("li", {}, "Note: " + text)))])];
}

// Says what to do with the answer.
function nextSteps({ trust }) {
  const { command, adds } = report.other_answer ?? {};
  const other = !command ? null : command === "decid fit" && framed ? element("li", {}, `Detailed analysis (button above): ${adds.replace(/;[^;]*$/, "")}.`)  // the time is the program's
    : element("li", {}, command === "decid fit" ? "Detailed analysis, " : "Quick estimate, ", element("code", {}, command), `: ${adds}.`);
  const items = trust === "not usable" ? ["Correct the recording or its settings as described above, then analyse it again."]
    : [...(trust === "caution" ? ["Follow the advice of each warning above, then analyse the recording again."] : []),
      "Compare people by the values relative to gravity, from recordings of the same protocol.",
      "Two recordings whose 90% intervals overlap may or may not differ. Use --group or --within: they give an interval of the difference."];
  return element("div", {}, element("h3", {}, "Next steps"),
    element("ul", { class: "plain" }, ...items.map(text => element("li", {}, text)), trust === "not usable" ? null : other));
}

// what: "Not analysed".
function failures(what) {
  if (report.failed.length === 0) return;
  document.getElementById("main").append(element("div", { class: "warning", role: "note", "aria-label": what },
    element("strong", {}, what), element("ul", {}, ...report.failed.map(text => element("li", {}, text)))));
}

// ---- all recordings ------------------------------------------------------------------------------------------------

const groupColours = ["--draw", "--again", "--third", "--fourth"];
const groupOf = index => report.groups ? report.groups.members[index].group : "";
const reasons = { tilt_of_other_size: "platform tilted by another angle", "not usable": "not usable", error: "not analysed",
  without_group: "without a group", without_session: "without a session", without_condition: "without a condition" };
// Returns why a comparison of groups leaves out a recording, or nothing.
const leftOut = index => report.groups ? report.groups.members[index].left_out : "";
const peopleText = count => count === 1 ? "1 person" : `${count} people`;

// Returns the usable recordings, so that summary figures cover only these: [recording, its place].
const sound = () => report.recordings.map((recording, index) => [recording, index]).filter(([{ trust }]) => trust !== "not usable");

function quantileOf(sorted, share) {
  const place = share * (sorted.length - 1), below = Math.floor(place);
  return sorted[below] + (place - below) * ((sorted[below + 1] ?? sorted[below]) - sorted[below]);
}

// Draws one dot per recording over the parameter's range, the middle 50% as a bar, and the median; one row per group.
function strip(parameter, rows) {
  const width = 340, row = 26, left = 6, right = width - 6;
  const x = value => left + (right - left) * Math.min(1, Math.max(0, (value - parameter.low) / (parameter.high - parameter.low)));
  const children = rows.flatMap(([, values, colour], at) => {
    const middle = row * at + row / 2, sorted = [...values].sort((a, b) => a - b);
    const dots = shape("path", { class: "dot", d: values.map((value, i) => `M${short(x(value))} ${short(middle + (i * 7 % 11 - 5) * 0.9)}h.01`).join("") });
    dots.style.stroke = `var(${colour})`;
    if (sorted.length === 0) return [];
    const bar = line(x(quantileOf(sorted, 0.25)), middle, x(quantileOf(sorted, 0.75)), middle, "half");
    return [line(left, middle, right, middle, "grid"), dots, bar, line(x(quantileOf(sorted, 0.5)), middle - 8, x(quantileOf(sorted, 0.5)), middle + 8, "median")];
  });
  return drawing(width, row * rows.length, `${parameter.description} of the recordings over the range ${compact(parameter.low)} to ${compact(parameter.high)}`, children);
}

function summaryTable() {
  const members = sound(), number = text => element("th", { scope: "col", class: "number" }, text);
  const names = report.groups ? report.groups.groups.map(({ name }) => name) : [""];
  const rows = report.recordings[0].parameters.map((parameter, p) => {
    const of = name => members.filter(([, index]) => name === "" || (groupOf(index) === name && !leftOut(index)))
      .map(([recording]) => recording.parameters[p].value).filter(value => !absent(value));
    const values = of(""), sorted = [...values].sort((a, b) => a - b), decimals = decimalsOf(parameter);
    const mean = values.reduce((sum, value) => sum + value, 0) / values.length;
    const deviation = Math.sqrt(values.reduce((sum, value) => sum + (value - mean) ** 2, 0) / (values.length - 1));
    return element("tr", {},
      nameCell(parameter), element("td", { class: "number value" }, `${fixed(mean, decimals)} \u00b1 ${fixed(deviation, decimals)}`),
      cell("Median", fixed(quantileOf(sorted, 0.5), decimals)),
      cell("Middle 50%", `${fixed(quantileOf(sorted, 0.25), decimals)} to ${fixed(quantileOf(sorted, 0.75), decimals)}`),
      element("td", { class: "range strip" }, strip(parameter, names.map((name, i) => [name, of(name), groupColours[i % groupColours.length]]))));
  });
  const legend = report.groups ? element("ul", { class: "legend" }, ...names.map((name, i) => {
    const mark = element("span", { class: "key", "aria-hidden": "true" });
    mark.style.background = `var(${groupColours[i % groupColours.length]})`;
    return element("li", {}, mark, `${name} (row ${i + 1})`);
  })) : null;
  return element("div", {}, element("h3", {}, "Summary"), legend, element("div", { class: "scroll" }, element("table", { class: "answer" },
    element("caption", {}, `${members.length} recordings, without those that are not usable. SD: standard deviation between recordings; it does not contain the uncertainty of each value. ` +
      "Dots: one per recording, within the model\u2019s limits (not a normal range). Bar: middle 50%. Vertical line: median." +
      (report.groups ? " A group\u2019s row shows the recordings that its comparison includes." : "") +
      (report.groups && report.groups.group_comparison.bodies_differ ? " Stiffness and damping are those of each person\u2019s own body here; the comparison above scales them to one body." : "")),
    element("thead", {}, element("tr", {}, element("th", { scope: "col" }, "Parameter"), number("Mean \u00b1 SD"), number("Median"), number("Middle 50%"),
      element("th", { scope: "col" }, "Within the model\u2019s limits"))),
    element("tbody", {}, ...rows))));
}

// Returns a compared parameter as its recordings show it. Groups leave out fixed ones.
const shownAs = ({ name }) => report.recordings[0].parameters.find(parameter => parameter.name === name);

// Says what the comparisons of groups show.
function verdictsBox({ intervals, sentences, notes = [] }) {
  return element("div", { class: "verdict", role: "note", "aria-label": "What differs?" },
    element("strong", {}, `What differs? By ${intervals}:`), ...notes.map(text => element("p", { class: "about" }, text)),
    element("ul", {}, ...sentences.map(text => element("li", {}, text))));
}

// Describes how the people of two groups are compared.
function pairedText({ paired, participants, unpaired_participants: unpaired }, [a, b]) {
  const summary = group => `${group.name}: ${peopleText(group.participants)}, ${group.recordings} ${group.recordings === 1 ? "recording" : "recordings"}`;
  const samples = `${summary(a)}; ${summary(b)}. `;
  if (!paired) return samples + "Different people: Welch\u2019s interval of the difference.";
  return samples + `Paired: the difference is within each of the ${peopleText(participants[0])} in both groups` +
    (unpaired > 0 ? `, without ${peopleText(unpaired)} in only one of them.` : ".");
}

function comparisonTable(comparison) {
  const { groups, parameters } = comparison, { group_comparison: settings } = report.groups;
  const number = text => element("th", { scope: "col", class: "number" }, text);
  const [a, b] = groups.map(name => report.groups.groups.find(group => group.name === name));
  const rows = parameters.map((parameter, p) => {
    const shown = shownAs(parameter), decimals = decimalsOf(shown), { factor } = shown;
    const inUnit = value => absent(value) ? "n/a" : fixed(factor * value, decimals);
    const mean = group => {
      const made = cell(group.name, inUnit(group.parameters[p].mean));
      made.append(" ", element("small", {}, `\u00b1 ${inUnit(group.parameters[p].sd)}`));
      return made;
    };
    const interval = (heading, limits) => cell(heading, absent(limits[0]) ? "\u2013" : between(limits.map(value => factor * value), decimals));
    const adjusted = interval("Adjusted", parameter.adjusted_interval95), [low, high] = parameter.adjusted_interval95;
    if (low > 0 || high < 0) adjusted.classList.add("strong");
    return element("tr", {}, nameCell(shown), mean(a), mean(b), cell("Difference", inUnit(parameter.difference)),
      interval("95%", parameter.interval95), adjusted, cell("g", absent(parameter.hedges_g) ? "\u2013" : fixed(parameter.hedges_g, 2)));
  });
  const pairs = settings.pairs === 1 ? "" : ` in ${settings.pairs} pairs of groups`;
  return element("div", {}, element("h3", {}, `${groups[0]} and ${groups[1]}`), element("p", { class: "about" }, pairedText(comparison, [a, b])),
    element("div", { class: "scroll" }, element("table", { class: "answer compared" },
      element("caption", {}, `Mean \u00b1 standard deviation of people. ${settings.parameters} parameters are compared${pairs}. Intervals are of the difference; the adjusted ones ` +
        `(Bonferroni, for ${settings.intervals} intervals) have a joint coverage of at least 95%, and are bold where they leave out 0. Hedges\u2019 g: the difference over the ` +
        "standard deviation of people; 0.2 is called small, 0.5 medium, 0.8 large."),
      element("thead", {}, element("tr", {}, element("th", { scope: "col" }, "Parameter"), number(groups[0]), number(groups[1]), number("Difference"),
        number("95% interval"), number("Adjusted interval"), number("Hedges\u2019 g"))),
      element("tbody", {}, ...rows))));
}

// Returns the cells of a hierarchical difference. shown: the parameter as its recordings show it.
function effectCells(parameter, shown) {
  const decimals = decimalsOf(shown), { factor } = shown;
  const interval = (heading, limits) => cell(heading, between(limits.map(value => factor * value), decimals));
  const simultaneous = interval("Simultaneous", parameter.simultaneous95), [low, high] = parameter.simultaneous95;
  if (low > 0 || high < 0) simultaneous.classList.add("strong");
  const difference = cell("Difference", fixed(factor * parameter.difference, decimals));
  difference.append(" ", element("small", {}, directionText(parameter.probability_of_direction)));
  return [difference, interval("95%", parameter.interval95), simultaneous, cell("Over sd", fixed(parameter.standardised, 2))];
}
const numberHeading = text => element("th", { scope: "col", class: "number" }, text);
const effectHeadings = () => ["Difference", "95% interval", "Simultaneous", "Over sd"].map(numberHeading);
const directionText = fraction => `${(100 * fraction).toFixed(1)}%`;

// Draws the difference of two groups by the hierarchical model, which accounts for the uncertainty of each recording.
function cohortTable(comparison) {
  const { draws, groups } = report.groups.hierarchical;
  const [a, b] = comparison.groups.map(name => groups.find(group => group.name === name));
  const rows = comparison.parameters.map((parameter, p) => {
    const shown = shownAs(parameter), decimals = decimalsOf(shown), { factor } = shown;
    const inUnit = value => fixed(factor * value, decimals);
    const mean = group => {
      const made = cell(group.name, inUnit(group.parameters[p].mean));
      made.append(" ", element("small", {}, `\u00b1 ${inUnit(group.parameters[p].between_sd)}`));
      return made;
    };
    return element("tr", {}, nameCell(shown), mean(a), mean(b), ...effectCells(parameter, shown));
  });
  return element("div", {}, element("h3", {}, `${a.name} and ${b.name}, hierarchical model`), element("div", { class: "scroll" }, element("table", { class: "answer compared" },
    element("caption", {}, "Population mean \u00b1 standard deviation between people, from the whole distribution of every recording: uncertain recordings count less, and " +
      "measurement noise is not counted as a difference between people. The simultaneous intervals hold together with 95%, and are bold where they leave out 0. " +
      "Over sd: the difference over the standard deviation between people. Below a difference: the probability of its sign. " +
      (comparison.participants_in_both > 0 ? `${peopleText(comparison.participants_in_both)} in both. ` : "") + `${draws} draws.`),
    element("thead", {}, element("tr", {}, element("th", { scope: "col" }, "Parameter"), numberHeading(a.name), numberHeading(b.name), ...effectHeadings())),
    element("tbody", {}, ...rows))));
}

// Draws how much more one group changes than another, or one session's difference than another's.
function interactionTable({ first, second, parameters }) {
  const rows = parameters.map(parameter => {
    const shown = shownAs(parameter);
    return element("tr", {}, nameCell(shown), ...effectCells(parameter, shown));
  });
  return element("div", {}, element("h3", {}, `Change from ${first[1]} to ${first[0]}, minus the change from ${second[1]} to ${second[0]}`),
    element("div", { class: "scroll" }, element("table", { class: "answer compared" },
      element("caption", {}, "Difference of two differences by the hierarchical model: 0 where both change alike."),
      element("thead", {}, element("tr", {}, element("th", { scope: "col" }, "Parameter"), ...effectHeadings())),
      element("tbody", {}, ...rows))));
}

// Draws how the parameters change with a covariate.
function covariateTable({ name, mean, unknown, parameters }) {
  const rows = parameters.map(parameter => {
    const shown = shownAs(parameter), { factor } = shown;
    const [low, high] = parameter.interval95, digits = value => (factor * value).toPrecision(3);
    const interval = cell("95%", `${digits(low)} to ${digits(high)}`);
    if (low > 0 || high < 0) interval.classList.add("strong");
    return element("tr", {}, nameCell(shown), cell("Slope", digits(parameter.slope)), interval, cell("Direction", directionText(parameter.probability_of_direction)));
  });
  return element("div", {}, element("h3", {}, `Change per unit of ${name}`), element("div", { class: "scroll" }, element("table", { class: "answer compared" },
    element("caption", {}, `By the hierarchical model, within the groups. Their means above are at ${name} = ${mean.toPrecision(4)}` +
      (unknown > 0 ? `; ${unknown} ${unknown === 1 ? "recording" : "recordings"} without a value: the person\u2019s in another one, else the group\u2019s mean. ` : ". ") +
      "Intervals of each parameter on its own, bold where they leave out 0."),
    element("thead", {}, element("tr", {}, element("th", { scope: "col" }, "Parameter"), ...["Slope", "95% interval", "Direction"].map(numberHeading))),
    element("tbody", {}, ...rows))));
}

// Draws how far the values of two visits of the same people agree.
function reliabilityTable({ groups, participants, parameters }) {
  const rows = parameters.filter(parameter => !absent(parameter.standard_error)).map(parameter => {
    const shown = shownAs(parameter), inUnit = value => compact(shown.factor * value), interval = parameter.icc_single_interval95;
    return element("tr", {}, nameCell(shown), cell("ICC(2,1)", fixed(parameter.icc_single, 2)), cell("95%", interval.every(absent) ? "n/a" : between(interval, 2)),
      cell("SEM", inUnit(parameter.standard_error)), cell("MDC", inUnit(parameter.minimal_detectable_change)), cell("Shown", percent(parameter.shown_fraction)));
  });
  return element("div", {}, element("h3", {}, `${groups[0]} and ${groups[1]}, reliability`), element("div", { class: "scroll" }, element("table", { class: "answer compared reliability" },
    element("caption", {}, `${peopleText(participants)} in both. SEM: standard error of measurement. MDC: minimal detectable change of the values above. These show only a part of a ` +
      "person\u2019s change: decid detects a true change above MDC / shown. n/a: the data do not determine it. " +
      "SEM and MDC include the effect of a treatment between the visits: use the MDC of people who were not treated."),
    element("thead", {}, element("tr", {}, element("th", { scope: "col" }, "Parameter"), ...["ICC(2,1)", "95% interval", "SEM", "MDC", "Shown"].map(numberHeading))),
    element("tbody", {}, ...rows))));
}

// Draws each person's changes between the groups of every comparison within people.
function changesTables() {
  const { hierarchical: model, own_changes: own } = report.groups, changes = model?.changes ?? own, nameOf = ({ groups }) => groups.join(" minus ");
  return [...new Set(changes.map(nameOf))].map(name => {
    const here = changes.filter(change => nameOf(change) === name), shown = here[0].parameters.map(shownAs);
    const cautious = here.filter(({ caution }) => caution).map(({ participant_id: person }) => person).join(", ");
    const changeCell = ({ difference, interval95, own_difference: ownDifference, own_interval95: ownInterval, changed }, p) => {
      const { factor } = shown[p], decimals = decimalsOf(shown[p]), made = cell(shown[p].name, fixed(factor * difference, decimals));
      const interval = ends => between(ends.map(value => factor * value), decimals);
      made.append(" ", element("small", {}, interval(interval95)));
      if (!absent(ownDifference)) made.append(" ", element("small", {}, `own ${fixed(factor * ownDifference, decimals)}, ${interval(ownInterval)}`));
      if (changed) made.classList.add("strong");
      return made;
    };
    return element("div", {}, element("h3", {}, `Change: ${name}, each person`), element("div", { class: "scroll" }, element("table", { class: "recordings changes" },
      element("caption", {}, (model ? "Differences with 95% intervals by the hierarchical model, which borrows from the group\u2019s mean change, and by the person\u2019s own recordings only (own): bold where both intervals leave out 0"
        : "Differences with 95% intervals: bold where these leave out 0") + ", else within measurement error. Above 0: higher in the first-named. " +
        `The ${here.length * shown.length} intervals are not adjusted for their number: ${model ? "at most about 1 of 20 is bold" : "about 1 of 20 leaves out 0"} by chance.` +
        (cautious ? ` A recording has a caution, so intervals may be too narrow: ${cautious}.` : "")),
      element("thead", {}, element("tr", {}, element("th", { scope: "col" }, "Person"), ...shown.map(parameter => numberHeading(symbolAndUnit(parameter))))),
      element("tbody", {}, ...here.map(({ participant_id: person, parameters }) => element("tr", {}, element("th", { scope: "row" }, person), ...parameters.map(changeCell)))))));
  });
}

// Describes what counts as a person, and which recordings no comparison of groups includes.
function groupNotes() {
  const { participant_column: column, left_out: out, bodies_differ: differ, mgh } = report.groups.group_comparison;
  const people = absent(column) ? "The table of groups has no column \u201cparticipant_id\u201d: each recording counts as a person. Several recordings of one person would make the intervals too narrow."
    : `Recordings with the same \u201c${column}\u201d are of one person and are averaged first; people are compared.`;
  const notInferred = report.groups.group_comparison.fixed_parameters;
  return element("div", {}, element("h3", {}, "Who is compared"), element("p", { class: "about" }, people),
    !differ ? null : element("p", { class: "about" }, `Stiffness and damping are scaled to one body, of m g h = ${mgh < 100 ? compact(mgh) : fixed(mgh, 0)} N m/rad. The values of each recording, and --table, are for the person\u2019s own body.`),
    notInferred.length === 0 ? null : element("p", { class: "about" }, `Fixed, and so not compared: ${notInferred.join(", ")}.`),
    out.length === 0 ? null : element("p", { class: "about" }, `Left out: ${out.length} ${out.length === 1 ? "recording" : "recordings"}: ` +
      out.map(({ file, group, reason }) => `${file} (${absent(group) ? "" : group + "; "}${reasons[reason]})`).join(", ") + "."));
}

// Draws the table of recordings. valueCell: returns the cell of a parameter; last: the last column's heading, and its
// content for a recording.
function recordingTable(valueCell, [heading, last]) {
  const recordings = report.recordings, grouped = Boolean(report.groups);
  const rows = recordings.map((recording, index) => {
    const link = element("a", { href: `#recording-${index + 1}` }, recording.file);
    link.addEventListener("click", () => show(index));
    return element("tr", {},
      element("th", { scope: "row", class: "file" }, link, recording.trust === "usable" ? null : element("span", { class: "description" }, recording.trust)),
      grouped ? element("td", {}, [groupOf(index), leftOut(index) ? "left out" : ""].filter(Boolean).join(", ")) : null,
      ...recording.parameters.map(parameter => element("td", { class: "number" }, valueCell(parameter))),
      element("td", { class: "number" }, last(recording)));
  });
  const kind = recordings.length > 12 ? "scroll tall" : "scroll";
  return element("div", {}, element("h3", {}, "The recordings"), element("div", { class: kind, tabindex: 0, role: "region", "aria-label": "Table of the recordings" },
    element("table", { class: "recordings" },
      element("thead", {}, element("tr", {}, element("th", { scope: "col" }, "Recording"), grouped ? element("th", { scope: "col" }, "Group") : null,
        ...recordings[0].parameters.map(parameter => element("th", { scope: "col", class: "number" }, parameter.description,
          element("span", { class: "description" }, symbolAndUnit(parameter)))),
        element("th", { scope: "col", class: "number" }, heading))),
      element("tbody", {}, ...rows))));
}

function contents(valueCell, last) {
  const recordings = report.recordings;
  if (recordings.length < 2) return;
  const count = kind => recordings.filter(({ trust }) => trust === kind).length;
  const counts = Object.keys(verdicts).filter(kind => count(kind) > 0).map(kind => `${count(kind)} ${kind}`);
  if (report.failed.length > 0) counts.push(`${report.failed.length} not analysed`);
  const nav = document.getElementById("contents");
  nav.append(element("h2", {}, `${recordings.length + report.failed.length} recordings`), element("p", { class: "about" }, counts.join(", ") + "."));
  if (report.groups?.verdicts.sentences.length > 0) nav.append(verdictsBox(report.groups.verdicts));
  if (report.groups) nav.append(groupNotes(), ...report.groups.comparisons.map(comparisonTable),
    ...(report.groups.hierarchical?.comparisons ?? []).map(cohortTable),
    ...(report.groups.hierarchical?.interactions ?? []).map(interactionTable),
    ...(report.groups.hierarchical?.covariates ?? []).map(covariateTable), ...report.groups.reliability.map(reliabilityTable), ...changesTables());
  if (sound().length > 2) nav.append(summaryTable());
  nav.append(recordingTable(valueCell, last));
  nav.hidden = false;
}

// ---- a part of the trial ---------------------------------------------------------------------------------------------

// Returns the controls of a window over the trial. choices: [text, seconds]; chosen: the first of them; from: where it begins;
// show(from, to) draws it.
function windowControls(choices, chosen, start, end, show) {
  const length = element("select", { "aria-label": "Length of the window" }, ...choices.map(([text, seconds]) => element("option", { value: seconds }, text)));
  length.selectedIndex = chosen;
  const slider = element("input", { type: "range", min: 0, max: end, step: 0.5, value: start, "aria-label": "Start of the window in seconds" });
  const shown = element("output");
  const put = () => {
    slider.max = Math.max(0, end - Number(length.value));
    slider.disabled = Number(slider.max) === 0;
    const from = Number(slider.value), to = Math.min(end, from + Number(length.value));
    shown.textContent = `${fixed(from, 1)} to ${fixed(to, 1)} s`;
    show(from, to);
  };
  for (const control of [length, slider]) control.addEventListener("input", put);
  put();
  return element("div", { class: "window-controls" }, element("label", {}, "Show ", length), element("label", {}, "from ", slider), shown);
}

// ---- each recording ------------------------------------------------------------------------------------------------

const openAtFirst = 3;  // the recordings of a page that has no more
const opened = [];      // a function each: draws the recording, once

// Adds a section for each recording. fill: appends a recording's content to a section. A single recording is shown; each of
// several recordings is folded, and is read and drawn when the user opens it.
function sections(fill) {
  const main = document.getElementById("main"), single = report.recordings.length === 1;
  report.recordings.forEach((recording, index) => {
    const id = `recording-${index + 1}`, title = element("h2", { id: `${id}-title` }, recording.file);
    const made = element("section", { id, "aria-labelledby": `${id}-title` });
    const fold = element("details", { class: "recording" }, element("summary", {}, title,
      element("span", { class: `badge ${recording.trust.replace(" ", "-")}` }, recording.trust)));
    made.append(single ? title : fold);
    main.append(made);
    let drawn = false;
    opened.push(() => {
      if (drawn) return;
      drawn = true;
      fold.open = true;
      fill(single ? made : fold, Object.assign(recording, JSON.parse(document.getElementById(`details-${index + 1}`).textContent)));
    });
    fold.addEventListener("toggle", () => { if (fold.open && !drawn) show(index); });
    if (report.recordings.length <= openAtFirst) opened[index]();
  });
  window.addEventListener("hashchange", showNamed);
  showNamed();
}

function show(index) {
  opened[index]();
  document.querySelector(`#recording-${index + 1} > details`)?.setAttribute("open", "");
  finish();
}

function showNamed() {
  const named = /^#recording-([1-9][0-9]*)$/.exec(location.hash);
  if (!named || !opened[named[1] - 1]) return;
  show(named[1] - 1);
  document.getElementById(`recording-${named[1]}`).scrollIntoView();
}

// Explains how to read the page before trusting a figure. whence: the origin of the values.
function howToRead(whence) {
  const items = [
    ["The coloured box", "says if you can use these values. Read it first."],
    ["Estimate \u00b1 uncertainty", `${whence} The uncertainty is one standard deviation (1 SD).`],
    ["90% interval", "It contains the true value in about nine of ten recordings, if the model describes the person."],
    ["Active stiffness, active damping", "Kp, Kd: how strongly the muscles respond, by way of the nerves, to lean and to its speed."],
    ["Passive stiffness, passive damping", "Kp_pass, Kd_pass: ankle, muscle and tendon, without nerves. Most recordings hardly determine the passive stiffness."],
    ["Sensory noise", "Nv: the noise of the sense of balance; 0 is none."],
    ["Tilt-speed threshold", "theta: the person does not perceive platform tilts slower than this."],
    ["Reaction delay", "delay: the time from sensing to torque, all of it in one number."],
    ["Relative to gravity", "Stiffness over the torque of gravity per angle (m g h), which compares bodies of different size. Damping relative to gravity is in seconds."],
    ["No normal values", "The model\u2019s limits are the range of its training trials, not the range of healthy people."],
  ];
  const made = element("details", { class: "help" }, element("summary", {}, "How to read this"),
    element("dl", {}, ...items.flatMap(([name, text]) => [element("dt", {}, name), element("dd", {}, text)])));
  // Paper shows the full text.
  window.addEventListener("beforeprint", () => { made.open = true; });
  window.addEventListener("afterprint", () => { made.open = false; });
  return made;
}
