// Plots of ports, fields of messages and expressions over time. They stay while other things are selected, and when the tab is loaded again.
import { ask, on, tell } from "./connection.js";
import { $, button, colour, download, element, put, steady } from "./elements.js";
import { seek } from "./recording.js";
import { onTab, shown, showTab } from "./tabs.js";

const MOST = 60_000; // samples to keep
const NOISE = 1e-9; // spans below are rounding errors
const FEW = 8; // up to this number, all parts of a value are plotted at once
const COLOURS = 8;
let times = [], charts = [], active = null, waiting = true, recording = null, topics = [];
let status = {}; // errors and parts of plotted values, by expression
const columns = new Map(); // values by expression, as long as `times`

class Chart {
  constructor(series = []) {
    this.series = series;
    this.zoomed = null; // the times that the viewer chose, s
    this.keys = element("ul", "", "keys");
    this.area = element("div", "", "area");
    this.host = element("figure", "", "chart");
    const actions = element("div", "", "chart-actions");
    actions.append(button("PNG", () => this.savePicture(), "small", "save this plot as a picture"),
      button("CSV", () => this.saveTable(), "small", "save these values as a table"),
      button("×", () => remove(this), "small", "close this plot"));
    const head = element("figcaption");
    head.append(this.keys, actions);
    this.host.append(head, this.area);
    this.host.onpointerdown = () => activate(this);
    new ResizeObserver(() => this.fit()).observe(this.area);
    $("charts").append(this.host);
    this.build();
  }

  // Creates the picture again, after a change of the series.
  build() {
    this.uplot?.destroy();
    this.units = [...new Set(this.series.map((one) => one.unit))];
    const axis = { stroke: () => colour("--quiet"), font: "11px system-ui", ticks: { show: false }, labelFont: "11px system-ui" };
    const grid = { stroke: () => colour("--line"), width: 1 };
    const vertical = this.units.map((unit, index) => ({ ...axis, scale: unit || "y", label: unit, size: 56, labelSize: unit ? 16 : 0, space: 24,
      side: index % 2 ? 1 : 3, grid: index ? { show: false } : grid, values: (_, splits) => splits.map((split) => String(+split.toPrecision(6))) }));
    const scales = Object.fromEntries(this.units.map((unit) => [unit || "y", { range: (_, low, high) => padded(low, high) }]));
    this.uplot = new window.uPlot({
      width: Math.max(this.area.clientWidth, 200), height: Math.max(this.area.clientHeight, 90), padding: [8, 12, 0, 4], legend: { show: false },
      cursor: { sync: { key: "plots" }, drag: { x: true, y: false, setScale: false }, bind: { dblclick: () => () => this.zoom(null) } },
      scales: { x: { time: false }, ...scales },
      axes: [{ ...axis, size: 24, grid, values: (_, splits) => splits.map((split) => `${+split.toFixed(3)} s`) }, ...vertical],
      series: [{}, ...this.series.map((one, index) => ({ scale: one.unit || "y", width: 1.6, points: { show: false },
        stroke: () => colour(`--plot-${index % COLOURS}`) }))],
      hooks: { setCursor: [() => this.showValues()], draw: [(uplot) => this.drawPosition(uplot)], setSelect: [(uplot) => this.choose(uplot)] },
    }, this.data(), this.area);
    this.uplot.over.addEventListener("click", (event) => {
      if (recording && !this.chosen) seek(Math.round(this.uplot.posToVal(event.offsetX, "x") / recording.seconds));
      this.chosen = false;
    });
    this.showKeys();
    this.draw();
  }

  data() {
    return [times, ...this.series.map((one) => columns.get(one.text) ?? times.map(() => null))];
  }

  // Zooms into the times over which the viewer has dragged.
  choose(uplot) {
    if (uplot.select.width < 4) return;
    this.chosen = true;
    this.zoom([uplot.posToVal(uplot.select.left, "x"), uplot.posToVal(uplot.select.left + uplot.select.width, "x")]);
    uplot.setSelect({ width: 0, height: 0, left: 0, top: 0 }, false);
  }

  zoom(range) {
    this.zoomed = range;
    this.draw();
  }

  range() {
    if (this.zoomed) return this.zoomed;
    const end = recording ? recording.length * recording.seconds : times.at(-1) ?? 1, span = Number($("plot-span").value);
    const begin = recording ? 0 : times[0] ?? 0;
    return [span ? Math.max(end - span, begin) : begin, Math.max(end, begin + 0.1)];
  }

  draw() {
    const [min, max] = this.range();
    this.uplot.batch(() => {
      this.uplot.setData(this.data(), false);
      this.uplot.setScale("x", { min, max });
    });
    this.showValues();
  }

  fit() {
    if (this.area.clientWidth) this.uplot.setSize({ width: this.area.clientWidth, height: Math.max(this.area.clientHeight, 90) });
  }

  drawPosition(uplot) {
    if (!recording) return;
    const { ctx, bbox: { top, height } } = uplot, x = uplot.valToPos(recording.position * recording.seconds, "x", true);
    ctx.fillStyle = colour("--strong");
    ctx.fillRect(x - 1, top, 2, height);
  }

  // The names of the series with their values at the cursor, otherwise their newest values.
  showKeys() {
    this.keys.replaceChildren(...this.series.map((one, index) => {
      const line = element("li", "", "key", { title: one.text }), swatch = element("i", "", "line");
      swatch.style.background = `var(--plot-${index % COLOURS})`;
      const away = button("×", () => this.toggle(one), "plain", `remove ${one.label}`);
      line.append(swatch, element("span", one.unit ? `${one.label}, ${one.unit}` : one.label, "series"), element("output"), away);
      const { error, choices } = status[one.text] ?? {};
      if (error) line.append(element("span", error.split("\n")[0], "error", { title: error }));
      if (choices) line.append(this.chooser(one, choices));
      return line;
    }));
    if (!this.series.length) this.keys.append(element("li", "Click a port or a field of a message, or write an expression above.", "hint"));
    this.showValues();
  }

  // A value that is not a number: the viewer chooses a part.
  chooser(one, choices) {
    const made = element("select", "", "", { "aria-label": `part of ${one.label}` });
    made.append(new Option("choose a part…", ""), ...choices.map((part) => new Option(part, part)));
    made.onchange = () => this.replace(one, [made.value]);
    return made;
  }

  replace(one, parts) {
    const made = parts.map((part) => ({ ...one, text: one.text + part, label: one.label + part }));
    this.series.splice(this.series.indexOf(one), 1, ...made.filter((part) => !this.series.some((other) => other.text === part.text)));
    changed(this);
  }

  toggle(one) {
    const at = this.series.findIndex((other) => other.text === one.text);
    if (at < 0) this.series.push(one);
    else this.series.splice(at, 1);
    changed(this);
  }

  showValues() {
    const at = this.uplot?.cursor.idx ?? times.length - 1;
    this.series.forEach((one, index) => {
      const value = columns.get(one.text)?.[at], cell = this.keys.children[index]?.querySelector("output");
      if (cell) put(cell, value === null || value === undefined ? "" : steady(value));
    });
  }

  name() {
    return this.series.map((one) => one.label).join("_").replace(/[^A-Za-z0-9_.]+/g, "_").slice(0, 60) || "plot";
  }

  savePicture() {
    const drawn = this.uplot.ctx.canvas, scale = devicePixelRatio || 1, line = 18 * scale, made = element("canvas");
    Object.assign(made, { width: drawn.width, height: drawn.height + line * (this.series.length + 0.5) });
    const context = made.getContext("2d");
    context.fillStyle = colour("--page");
    context.fillRect(0, 0, made.width, made.height);
    context.font = `${12 * scale}px system-ui`;
    this.series.forEach((one, index) => {
      context.fillStyle = colour(`--plot-${index % COLOURS}`);
      context.fillText(`— ${one.unit ? `${one.label}, ${one.unit}` : one.label}`, 12 * scale, line * (index + 1));
    });
    context.drawImage(drawn, 0, line * (this.series.length + 0.5));
    made.toBlob((blob) => download(`${this.name()}.png`, blob));
  }

  saveTable() {
    const [from, to] = this.range(), cell = (text) => `"${text.replace(/"/g, '""')}"`;
    const lines = [["time_s", ...this.series.map((one) => cell(one.unit ? `${one.text} ${one.unit}` : one.text))].join(",")];
    times.forEach((time, row) => {
      if (time >= from && time <= to) lines.push([time, ...this.series.map((one) => columns.get(one.text)?.[row] ?? "")].join(","));
    });
    download(`${this.name()}.csv`, new Blob([`${lines.join("\n")}\n`], { type: "text/csv" }));
  }
}

// Returns the range of an axis for values from `low` to `high`.
function padded(low, high) {
  if (!Number.isFinite(low) || !Number.isFinite(high)) return [0, 1];
  const margin = high - low > NOISE ? (high - low) * 0.08 : Math.max(Math.abs(high) * 0.1, 0.1);
  return [low - margin, high + margin];
}

const texts = () => [...new Set(charts.flatMap((chart) => chart.series.map((one) => one.text)))];
const tellRun = () => ask({ ask: "plots", series: texts() });

// Called after the series of a chart have changed.
function changed(chart) {
  const wanted = texts();
  for (const text of columns.keys()) if (!wanted.includes(text)) columns.delete(text);
  for (const text of wanted) if (!columns.has(text)) columns.set(text, times.map(() => null));
  sessionStorage.setItem("plots", JSON.stringify(charts.map((one) => one.series)));
  $("plots-tab").textContent = wanted.length ? `Plots ${wanted.length}` : "Plots";
  tellRun();
  if (charts.includes(chart)) {
    chart.build();
    chart.host.scrollIntoView({ block: "nearest" });
  }
  tell("plots");
}

function activate(chart) {
  active = chart;
  for (const other of charts) other.host.classList.toggle("active", other === chart && charts.length > 1);
}

function make(series) {
  const chart = new Chart(series);
  charts.push(chart);
  activate(chart);
  return chart;
}

function remove(chart) {
  charts = charts.filter((other) => other !== chart);
  chart.uplot.destroy();
  chart.host.remove();
  if (active === chart) activate(charts.at(-1) ?? make());
  changed(chart);
}

// Plots a value in the active chart, or removes it from there.
export function plot(text, label, unit = "") {
  showTab("plots");
  active.toggle({ text, label, unit: unit ?? "" });
}

export const isPlotted = (text) => texts().some((one) => one.startsWith(text));

on("samples", ({ times: added, values }) => {
  added.forEach((time, row) => {
    if (times.length && time < times.at(-1)) { // the time was reset, or a recording is sampled again
      times.length = 0;
      for (const column of columns.values()) column.length = 0;
    }
    if (time === times.at(-1)) return;
    times.push(time);
    for (const [text, column] of columns) column.push(values[text]?.[row] ?? null);
  });
  if (times.length > MOST) for (const column of [times, ...columns.values()]) column.splice(0, MOST / 10);
  waiting = true;
});
on("plotting", (found) => {
  status = found;
  for (const chart of charts) {
    for (const one of [...chart.series]) {
      const { choices } = found[one.text] ?? {};
      if (choices && choices.length <= FEW) chart.replace(one, choices);
    }
    chart.showKeys();
  }
});
on("frame", ({ facts }) => {
  if (recording?.position !== facts.recording?.position || recording?.length !== facts.recording?.length) waiting = true;
  if (!recording && facts.recording) $("plot-span").value = "0";
  recording = facts.recording ?? null;
});
on("stage", (stage) => { topics = stage.topics; offer(); });
on("open", () => { if (texts().length) tellRun(); });
on("graph", (graph) => offer(graph));
onTab((name) => { if (name === "plots") redraw(); });

// The expressions that the input offers: topics, and the ports of the selected graph.
function offer(graph) {
  const ports = Object.entries(graph?.nodes ?? {}).flatMap(([node, { ports: all }]) =>
    all.map((one) => `port("${graph.name}/${node}.${one.side}:${one.name}")`));
  $("plot-texts").replaceChildren(...topics.map((topic) => new Option("", `message("${topic}")`)), ...ports.map((text) => new Option("", text)));
}

function redraw() {
  for (const chart of charts) { chart.fit(); chart.draw(); }
}

setInterval(() => {
  if (!waiting || shown !== "plots" || document.hidden) return;
  waiting = false;
  redraw();
}, 100);

$("plot-form").onsubmit = (event) => {
  event.preventDefault();
  const given = $("plot-add").value.trim();
  const topic = topics.filter((one) => given.startsWith(one)).sort((a, b) => b.length - a.length)[0];
  const text = topic ? `message("${topic}")${given.slice(topic.length)}` : given; // as in `/odom.pose.pose.position.x`
  if (text) active.toggle({ text, label: text.replace(/(?:message|port)\("([^"]*)"\)/g, "$1"), unit: "" });
  $("plot-add").value = "";
};
$("plot-new").onclick = () => make();
$("plot-span").onchange = () => { for (const chart of charts) chart.zoom(null); };
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);

let saved = [];
try { saved = JSON.parse(sessionStorage.getItem("plots")) ?? []; } catch { /* of another version */ }
for (const series of saved) make(series);
if (!charts.length) make();
changed(null);
