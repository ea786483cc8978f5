// Drives a robot while a key is held down; releasing the key, losing the focus or hiding the page stops the robot.
import { ask, on } from "./connection.js";
import { $ } from "./elements.js";
import { onSelect, selected } from "./selection.js";

const KEYS = { KeyW: [0.5, 0, 0], ArrowUp: [0.5, 0, 0], KeyS: [-0.5, 0, 0], ArrowDown: [-0.5, 0, 0],
  KeyA: [0, 0, 1], ArrowLeft: [0, 0, 1], KeyD: [0, 0, -1], ArrowRight: [0, 0, -1] };
const held = new Set();
let driving = false, drives = {};

on("stage", (stage) => {
  const chosen = selected.robot in drives ? $("robot").value : selected.robot || $("robot").value;
  drives = stage.drives;
  const robots = Object.keys(drives);
  $("robot").replaceChildren(...robots.map((name) => new Option(name, name)));
  if (robots.includes(chosen)) $("robot").value = chosen;
  $("driving").hidden = $("wheel").hidden = robots.length === 0;
});

onSelect(() => {
  if (!(selected.robot in drives) || $("robot").value === selected.robot) return;
  release();
  $("robot").value = selected.robot;
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

function press(event) {
  if ($("wheel").getAttribute("aria-pressed") !== "true" || !KEYS[event.code]) return;
  if (event.ctrlKey || event.altKey || event.metaKey || event.target.closest?.("input, select, textarea")) return;
  event.preventDefault();
  event.stopImmediatePropagation(); // the 3D part uses these keys for its camera, the tree for its cursor
  held.add(event.code);
  drive();
}

function lift(event) {
  if (held.delete(event.code)) drive();
}

// Listens in a window: the focused window gets the keys, and a click into the 3D part focuses its frame. A repeated call changes nothing.
function listen(other) {
  other.addEventListener("keydown", press, true);
  other.addEventListener("keyup", lift, true);
  other.addEventListener("blur", release);
}

listen(window);
listen($("world").contentWindow); // the 3D part may have loaded before this module
$("world").addEventListener("load", () => listen($("world").contentWindow));
$("wheel").onclick = () => {
  const pressed = $("wheel").getAttribute("aria-pressed") !== "true";
  $("wheel").setAttribute("aria-pressed", String(pressed));
  if (!pressed) release();
};
$("robot").onchange = release;
document.addEventListener("visibilitychange", () => { if (document.hidden) release(); });
setInterval(() => { if (held.size) drive(); }, 100);
