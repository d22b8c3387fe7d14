// Charts as SVG in the colours of page.css, after common.js. A chart is drawn as wide as its place, again when that changes,
// and for paper as wide as a sheet. Its values are read with the pointer.

const redraws = [];  // a function each chart, given whether it is for paper

// ---- shapes --------------------------------------------------------------------------------------------------------

function shape(tag, attributes = {}, ...children) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children.filter(child => child !== null));
  return made;
}

const short = value => Number(value.toFixed(1));
const label = (x, y, text, kind = "") => shape("text", { x: short(x), y: short(y), class: kind }, text);
const line = (x1, y1, x2, y2, kind) => shape("line", { x1: short(x1), y1: short(y1), x2: short(x2), y2: short(y2), class: kind });
const pathOf = points => points.map(([x, y], i) => `${i ? "L" : "M"}${short(x)} ${short(y)}`).join("");
const path = (points, kind) => shape("path", { d: pathOf(points), class: kind });
const dotsOf = points => points.map(([x, y]) => `M${short(x)} ${short(y)}h.01`).join("");
const drawing = (width, height, text, children) =>
  shape("svg", { viewBox: `0 0 ${short(width)} ${short(height)}`, role: "img", "aria-label": text }, ...children);

// ---- axes ----------------------------------------------------------------------------------------------------------

// Returns round numbers between two limits, about as many as wanted.
function ticks(low, high, wanted) {
  const rough = (high - low) / wanted, power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find(factor => factor * power >= rough * 0.999);
  const first = Math.ceil(low / step - 1e-9), count = Math.floor(high / step + 1e-9) - first + 1;
  return Array.from({ length: Math.max(0, count) }, (_, i) => Number(((first + i) * step).toPrecision(12)));
}

// Returns the same for a logarithmic axis: the most digits a decade that fit, or every second, third... power of ten.
function logarithmicTicks(low, high, wanted) {
  const first = Math.floor(Math.log10(low)), powers = Array.from({ length: Math.ceil(Math.log10(high)) - first + 1 }, (_, i) => first + i);
  const made = (digits, every = 1) => powers.filter(power => power % every === 0)
    .flatMap(power => digits.map(digit => Number(`${digit}e${power}`))).filter(at => at >= low * 0.999 && at <= high * 1.001);
  const fitting = [[1, 2, 3, 4, 5, 6, 7, 8, 9], [1, 2, 5], [1, 3], [1]].map(digits => made(digits)).find(({ length }) => length <= wanted);
  const found = fitting ?? made([1], Math.ceil(powers.length / wanted));
  return found.length < 2 ? ticks(low, high, wanted) : found;
}

// Returns the limits of an axis: its own, or those of the values with a margin.
function limitsOf({ low, high, logarithmic, names, zero }, values, margin) {
  if (names) return [-0.5, names.length - 0.5];
  const shown = values.filter(value => Number.isFinite(value) && (!logarithmic || value > 0));
  if (zero) shown.push(0);
  let least = Infinity, most = -Infinity;
  for (const value of shown) {
    least = Math.min(least, value);
    most = Math.max(most, value);
  }
  if (least > most) [least, most] = logarithmic ? [0.1, 1] : [0, 1];
  if (least === most) [least, most] = logarithmic ? [least / 2, 2 * most] : [least - (Math.abs(least) / 2 || 0.5), most + (Math.abs(most) / 2 || 0.5)];
  const room = logarithmic ? (most / least) ** margin : margin * (most - least);
  return [low ?? (zero && least === 0 ? 0 : logarithmic ? least / room : least - room), high ?? (logarithmic ? most * room : most + room)];
}

// Returns where a value of the axis is between two places.
function scaleOf([low, high], logarithmic, from, to) {
  const by = logarithmic ? Math.log : Number;
  return value => from + (to - from) * Math.min(1, Math.max(0, (by(value) - by(low)) / (by(high) - by(low))));
}

// ---- charts --------------------------------------------------------------------------------------------------------

// Splits a line where a value is missing.
function runsOf(points) {
  const runs = [[]];
  for (const point of points) {
    if (point.slice(1).every(Number.isFinite)) runs.at(-1).push(point);
    else if (runs.at(-1).length > 0) runs.push([]);
  }
  return runs.filter(run => run.length > 0);
}

// Keeps of each pixel's column the first, the lowest, the highest and the last of a line's points.
function thinned(points, width) {
  if (points.length < 4 * width) return points;
  const columns = new Map();
  points.forEach(([x, y], i) => {
    const kept = columns.get(Math.floor(x));
    if (!kept) columns.set(Math.floor(x), [i, i, i, i]);
    else columns.set(Math.floor(x), [kept[0], y < points[kept[1]][1] ? i : kept[1], y > points[kept[2]][1] ? i : kept[2], i]);
  });
  return [...columns.values()].flatMap(kept => [...new Set(kept)].sort((a, b) => a - b)).map(i => points[i]);
}

const stepsOf = points => points.flatMap(([x, y], i) => i ? [[x, points[i - 1][1]], [x, y]] : [[x, y]]);

// A mark is of one kind:  line: [[x, y], ...], and dots: true or stepped: true   band: [[x, low, high], ...]
//   bars: [[from, to, height], ...]   level: y   upright: x   image: the address of a picture that fills the frame
// and has a name, and a class of page.css.
const markPoints = ({ line, band, bars }) => line ?? band ?? bars?.map(([from, to, height]) => [(from + to) / 2, height, from, to]) ?? [];

function markShapes(mark, points, x, y, { left, right, top, bottom }) {
  const kind = mark.class;
  if (mark.image) return [shape("image", { href: mark.image, x: left, y: top, width: right - left, height: bottom - top, preserveAspectRatio: "none" })];
  if ("level" in mark) return [line(left, y(mark.level), right, y(mark.level), kind)];
  if ("upright" in mark) return [line(x(mark.upright), top, x(mark.upright), bottom, kind), label(x(mark.upright) + 6, top + 14, mark.text)];
  if (mark.bars) return points.map(([, height, from, to]) => shape("rect", { class: `bar-${kind}`, x: short(x(from)), width: short(Math.max(0.5, x(to) - x(from))),
    y: short(Math.min(y(0), y(height))), height: short(Math.abs(y(height) - y(0))) }));
  const runs = runsOf(points);
  if (mark.band) return runs.map(run => path([...run.map(([at, low]) => [x(at), y(low)]), ...run.map(([at, , high]) => [x(at), y(high)]).reverse()], kind));
  const drawn = runs.map(run => run.map(([at, value]) => [x(at), y(value)]));
  const lines = drawn.filter(run => run.length > 1).map(run => path(mark.stepped ? stepsOf(run) : thinned(run, right - left), kind));
  return mark.dots || (lines.length === 0 && drawn.length > 0) ? [...lines, shape("path", { d: drawn.map(dotsOf).join(""), class: `${kind} points` })] : lines;
}

const legendMark = mark => shape("svg", { viewBox: "0 0 24 12", "aria-hidden": "true" },
  mark.band || mark.bars ? shape("rect", { x: 0, y: 1, width: 24, height: 10, class: mark.bars ? `bar-${mark.class}` : mark.class })
    : path([[0, 6], [24, 6]], mark.class));

const rounded = value => minus(String(Number(value.toPrecision(4))));
// Returns "Angle" and "deg" of "Angle (deg)".
const nameAndUnit = (text = "") => /^(.*?)(?: \((.*)\))?$/.exec(text).slice(1);

// Returns the points of lines and bars that are nearest to a place of the x axis, as { at, lines of text }.
function readings(marks, place, { x, y }) {
  const wanted = x.names ? Math.round(place) : place, distance = ([at]) => Math.abs(at - wanted), nearer = (best, point) => best && distance(best) <= distance(point) ? best : point;
  const near = marks.filter(({ line, bars }) => line || bars).map(mark =>
    [mark, markPoints(mark).filter(([, value]) => Number.isFinite(value)).reduce(nearer, null)]).filter(([, point]) => point);
  if (near.length === 0) return null;
  const [at, , from, to] = near.map(([, point]) => point).reduce(nearer), [axis, axisUnit] = nameAndUnit(x.text), [value, unit] = nameAndUnit(y.text);
  const text = x.names ? x.names[Math.round(at)] : from === undefined ? rounded(at) : `${compact(from)} to ${compact(to)}`;
  const here = near.filter(([, point]) => x.names ? Math.round(point[0]) === Math.round(at) : point[0] === at);
  return { at, lines: [`${axis ? axis + ": " : ""}${text} ${axisUnit ?? ""}`, ...here.map(([mark, point]) => `${mark.name ?? value}: ${rounded(point[1])} ${unit ?? ""}`)] };
}

// Shows the readings beside the pointer, and a line where they are.
function followPointer(holder, svg, find, frame) {
  const tip = element("div", { class: "tip", hidden: "" }), cursor = line(0, frame.top, 0, frame.bottom, "edge cursor");
  cursor.style.visibility = "hidden";
  svg.append(cursor);
  svg.addEventListener("pointermove", event => {
    const box = svg.getBoundingClientRect(), found = find((event.clientX - box.left) * svg.viewBox.baseVal.width / box.width);
    tip.hidden = !found;
    cursor.style.visibility = found ? "visible" : "hidden";
    if (!found) return;
    tip.replaceChildren(...found.lines.map(text => element("div", {}, text)));
    cursor.setAttribute("x1", found.x);
    cursor.setAttribute("x2", found.x);
    tip.style.left = Math.max(0, Math.min(event.clientX - box.left + 14, box.width - tip.offsetWidth)) + "px";
    tip.style.top = Math.max(0, event.clientY - box.top - tip.offsetHeight - 10) + "px";
  });
  svg.addEventListener("pointerleave", () => {
    tip.hidden = true;
    cursor.style.visibility = "hidden";
  });
  holder.replaceChildren(svg, tip);
}

// Returns the chart as an element and draw(from, to), which shows a part of the x axis.
//   title: the name that is read out   x, y: { text, low, high, logarithmic, names of places 0, 1, ..., zero: it is in the axis }
//   sheet: its width on paper in CSS pixels
function plot({ title, x: xAxis, y: yAxis, marks, height = 320, sheet = 688, legend = true }) {
  const holder = element("div", { class: "plot" }), named = marks.filter(({ name, image }) => name && !image);
  const all = marks.map(mark => [mark, markPoints(mark)]);
  let view = limitsOf(xAxis, all.flatMap(([mark, points]) => points.flatMap(point => mark.bars ? point.slice(2) : [point[0]])), 0);
  const draw = (paper = false) => {
    const width = paper ? sheet : holder.clientWidth || 900, tall = paper ? Math.min(height, 230) : height;
    const seen = all.map(([mark, points]) => [mark, points.filter(([at]) => at >= view[0] && at <= view[1])]);
    const span = limitsOf(yAxis, seen.flatMap(([mark, points]) => "level" in mark ? [mark.level] : points.flatMap(point => point.slice(1, mark.band ? 3 : 2))), 0.04);
    const yTicks = (yAxis.logarithmic ? logarithmicTicks : ticks)(...span, Math.max(3, tall / 45)), yTexts = yTicks.map(at => minus(String(at)));
    const rotated = xAxis.names && Math.max(...xAxis.names.map(name => name.length)) * 7.5 > (width - 60) / xAxis.names.length;
    const frame = { left: 26 + 7.2 * Math.max(...yTexts.map(text => text.length)), right: width - 10, top: 8, bottom: tall - (rotated ? 72 : 40) };
    const x = scaleOf(view, xAxis.logarithmic, frame.left, frame.right), y = scaleOf(span, yAxis.logarithmic, frame.bottom, frame.top);
    const xTicks = xAxis.names ? xAxis.names.map((_, i) => i) : (xAxis.logarithmic ? logarithmicTicks : ticks)(...view, Math.max(3, width / 80));
    const xText = at => xAxis.names ? xAxis.names[at] : minus(String(at));
    const xLabel = at => rotated ? shape("text", { transform: `translate(${short(x(at) + 4)} ${frame.bottom + 14}) rotate(-40)`, class: "end" }, xText(at))
      : label(x(at), frame.bottom + 18, xText(at), "middle");
    const svg = drawing(width, tall, title, [
      ...yTicks.flatMap((at, i) => [line(frame.left, y(at), frame.right, y(at), "grid"), label(frame.left - 6, y(at) + 4, yTexts[i], "end")]),
      ...xTicks.flatMap(at => [xAxis.names ? null : line(x(at), frame.bottom, x(at), frame.bottom + 4, "frame"), xLabel(at)]),
      label((frame.left + frame.right) / 2, tall - 5, xAxis.text ?? "", "middle"),
      shape("text", { transform: `translate(12 ${short((frame.top + frame.bottom) / 2)}) rotate(-90)`, class: "middle" }, yAxis.text),
      ...seen.flatMap(([mark, points]) => markShapes(mark, points, x, y, frame)),
      shape("rect", { x: short(frame.left), y: frame.top, width: short(frame.right - frame.left), height: frame.bottom - frame.top, class: "frame" }),
    ]);
    const back = xAxis.logarithmic ? part => view[0] * (view[1] / view[0]) ** part : part => view[0] + part * (view[1] - view[0]);
    followPointer(holder, svg, at => {
      const found = readings(seen.map(([mark]) => mark), back((at - frame.left) / (frame.right - frame.left)), { x: xAxis, y: yAxis });
      return found && found.at >= view[0] && found.at <= view[1] ? { x: x(found.at), lines: found.lines } : null;
    }, frame);
  };
  redraws.push(draw);
  return {
    made: element("div", { class: "chart" }, legend && named.length > 1 ? element("ul", { class: "legend" },
      ...named.map(mark => element("li", {}, legendMark(mark), mark.name))) : null, holder),
    draw: (from, to) => {
      view = [from, to];
      draw();
    },
  };
}

// Returns a figure: its heading, charts, and the caption that they share.
const chartFigure = (title, caption, ...charts) => element("figure", {}, element("h3", {}, title), ...charts.map(({ made }) => made),
  element("figcaption", {}, caption));

const redraw = paper => redraws.forEach(draw => draw(paper === true));
window.addEventListener("resize", redraw);
window.addEventListener("beforeprint", () => redraw(true));
window.addEventListener("afterprint", redraw);
