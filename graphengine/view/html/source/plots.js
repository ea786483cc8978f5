// Plots of values over time with uPlot: limits, the shown time, and a click that selects a time.

import { lastBefore } from "./decode.js";

const HEIGHT = 130; // px
const NOISE = 1e-9; // values and spans below are rounding errors

export class Plots {
  // `seek` is called with the time that a click selects, s.
  constructor(host, plots, duration, seek) {
    this.plots = plots.map((plot) => new Plot(host, plot, duration, seek));
    new ResizeObserver(() => this.plots.forEach((plot) => plot.fit())).observe(host);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.plots.forEach((plot) => plot.uplot.redraw()));
  }

  show(time) {
    for (const plot of this.plots) plot.show(time);
  }
}

class Plot {
  constructor(host, data, duration, seek) {
    this.data = data;
    this.limits = data.limits.filter((limit) => limit !== null);
    const figure = document.createElement("figure");
    const caption = figure.appendChild(document.createElement("figcaption"));
    caption.append(`${data.name}${data.unit ? ` (${data.unit})` : ""}`);
    this.value = caption.appendChild(document.createElement("output"));
    this.host = figure.appendChild(document.createElement("div"));
    host.append(figure);
    const values = Array.from(data.values, (value) => (Number.isFinite(value) ? value : null));
    const quiet = () => colour("--quiet");
    const axis = { stroke: quiet, font: "11px system-ui", grid: { stroke: () => colour("--line"), width: 1 }, ticks: { show: false } };
    this.uplot = new window.uPlot({
      width: 300, height: HEIGHT, padding: [10, 16, 0, 0], legend: { show: false }, cursor: { drag: { x: false, y: false }, y: false },
      scales: { x: { time: false, range: [0, duration || 1] }, y: { range: (_, low, high) => this.range(low, high) } },
      axes: [{ ...axis, size: 22, values: (_, splits) => splits.map((split) => `${split} s`) }, { ...axis, size: 48, space: 24 }],
      series: [{}, { stroke: () => colour("--strong"), width: 1.5, points: { show: false } }],
      hooks: { drawAxes: [() => this.drawLimits()] },
    }, [Array.from(data.times), values], this.host);
    this.line = this.uplot.over.appendChild(document.createElement("div"));
    this.line.className = "now";
    this.uplot.over.addEventListener("click", (event) => seek(this.uplot.posToVal(event.offsetX, "x")));
  }

  // Returns the range of the y axis, which contains the limits.
  range(low, high) {
    const all = [low, high, ...this.limits].filter((value) => Number.isFinite(value));
    const [least, most] = all.length ? [Math.min(...all), Math.max(...all)] : [0, 1];
    const margin = most - least > NOISE ? (most - least) * 0.08 : Math.max(Math.abs(most) * 0.1, 0.1);
    return [least - margin, most + margin];
  }

  drawLimits() {
    const { ctx, bbox: { left, top, width, height } } = this.uplot;
    const [lower, upper] = this.data.limits.map((limit) => (limit === null ? null : this.uplot.valToPos(limit, "y", true)));
    ctx.save();
    ctx.fillStyle = colour("--forbidden");
    if (lower !== null) ctx.fillRect(left, lower, width, top + height - lower);
    if (upper !== null) ctx.fillRect(left, top, width, upper - top);
    ctx.fillStyle = colour("--error");
    for (const place of [lower, upper]) if (place !== null) ctx.fillRect(left, place - 1, width, 2);
    ctx.restore();
  }

  fit() {
    this.uplot.setSize({ width: this.host.clientWidth, height: HEIGHT });
    this.show(this.time ?? 0);
  }

  show(time) {
    this.time = time;
    this.line.style.left = `${this.uplot.valToPos(time, "x")}px`;
    const value = this.data.values[lastBefore(this.data.times, time)];
    const limited = this.data.limits;
    this.value.textContent = Number.isFinite(value) ? (Math.abs(value) < NOISE ? 0 : value).toPrecision(3) : "–";
    this.value.className = (limited[0] !== null && value < limited[0]) || (limited[1] !== null && value > limited[1]) ? "beyond" : "";
  }
}

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name);
