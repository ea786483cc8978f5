// The plot of a port of the selected node.
import { $, element } from "./elements.js";

const SECONDS = 30;
const points = [];
let port = null;

// Selects the port to plot; null: none.
export function plot(name) {
  port = name;
  points.length = 0;
}

export function plotArea() {
  const area = element("div");
  const canvas = element("canvas");
  canvas.hidden = true;
  area.append(canvas, element("p", "", "place caption"));
  return area;
}

// Called with the values of each frame.
export function plotted(values, time) {
  const value = values[port];
  if (typeof value !== "number") return;
  if (points.at(-1)?.[0] > time) points.length = 0; // the time was reset
  if (points.at(-1)?.[0] === time) points.pop();
  points.push([time, value]);
  while (points[0][0] < time - SECONDS) points.shift();
  const canvas = $("node-side").querySelector("canvas");
  canvas.hidden = false;
  const [wide, high] = [(canvas.width = canvas.clientWidth), (canvas.height = canvas.clientHeight)];
  const numbers = points.map(([, number]) => number);
  const [low, top] = [Math.min(...numbers), Math.max(...numbers)];
  const context = canvas.getContext("2d");
  const style = getComputedStyle(document.documentElement);
  context.strokeStyle = style.getPropertyValue("--strong");
  context.beginPath();
  for (const [then, number] of points) {
    const x = wide * (1 - (time - then) / SECONDS);
    const y = high - 6 - (high - 12) * (top > low ? (number - low) / (top - low) : 0.5);
    context.lineTo(x, y);
  }
  context.stroke();
  const range = `${+low.toPrecision(4)} to ${+top.toPrecision(4)}`;
  $("node-side").querySelector(".caption").textContent = `${port}: ${range} in the last ${SECONDS} s`;
}
