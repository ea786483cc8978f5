// The keyboard drives while a key is held down; a released key, a lost focus and a hidden page stop the robot.
import { ask, on } from "./connection.js";
import { $ } from "./elements.js";

const KEYS = { KeyW: [0.5, 0, 0], ArrowUp: [0.5, 0, 0], KeyS: [-0.5, 0, 0], ArrowDown: [-0.5, 0, 0],
  KeyA: [0, 0, 1], ArrowLeft: [0, 0, 1], KeyD: [0, 0, -1], ArrowRight: [0, 0, -1] };
const held = new Set();
let driving = false, drives = {};

on("stage", (stage) => {
  drives = stage.drives;
  const robots = Object.keys(drives);
  $("robot").replaceChildren(...robots.map((name) => new Option(name, name)));
  $("driving").hidden = $("wheel").hidden = robots.length === 0;
});

function drive() {
  const topic = drives[$("robot").value];
  if (!topic) return;
  const twist = [0, 0, 0];
  for (const key of held) KEYS[key].forEach((part, axis) => { twist[axis] += part; });
  if (held.size) ask({ ask: "drive", topic, twist });
  else if (driving) ask({ ask: "drive", topic, twist: null });
  driving = held.size > 0;
}

function release() {
  held.clear();
  drive();
}

$("wheel").onclick = () => {
  const pressed = $("wheel").getAttribute("aria-pressed") !== "true";
  $("wheel").setAttribute("aria-pressed", String(pressed));
  if (!pressed) release();
};
addEventListener("keydown", (event) => {
  if ($("wheel").getAttribute("aria-pressed") !== "true" || !KEYS[event.code]) return;
  if (event.target.matches("input, select")) return;
  event.preventDefault();
  held.add(event.code);
  drive();
});
addEventListener("keyup", (event) => { if (held.delete(event.code)) drive(); });
addEventListener("blur", release);
document.addEventListener("visibilitychange", () => { if (document.hidden) release(); });
setInterval(() => { if (held.size) drive(); }, 100);
