// Drives a robot, and holds keys that nodes read, while keys or buttons are held down; releasing them, losing the focus or hiding the
// page releases all.
import { ask, on } from "./connection.js";
import { $, element, put } from "./elements.js";
import { onSelect, selected } from "./selection.js";

const WAYS = { KeyW: [1, 0], ArrowUp: [1, 0], KeyS: [-1, 0], ArrowDown: [-1, 0], KeyA: [0, 1], ArrowLeft: [0, 1], KeyD: [0, -1], ArrowRight: [0, -1] };
const AGAIN = 100; // ms after which held keys are sent again, so that the run notices a lost page
const NAMES = { Period: "Period", Comma: "Comma", Slash: "Slash", Backslash: "Backslash", Semicolon: "Semicolon", Quote: "Apostrophe", Minus: "Minus",
  Equal: "Equal", Backquote: "GraveAccent", BracketLeft: "LeftBracket", BracketRight: "RightBracket", Space: "Space", Enter: "Enter", Tab: "Tab",
  Backspace: "Backspace", Delete: "Del", Insert: "Insert", Home: "Home", End: "End", PageUp: "PageUp", PageDown: "PageDown", CapsLock: "CapsLock",
  ShiftLeft: "LeftShift", ShiftRight: "RightShift", ControlLeft: "LeftControl", ControlRight: "RightControl", AltLeft: "LeftAlt", AltRight: "RightAlt" };
const held = new Set();
let driving = false, sent = false, drives = {}, read = false;

on("stage", (stage) => {
  const chosen = selected.robot in drives ? $("robot").value : selected.robot || $("robot").value;
  drives = stage.drives;
  read = stage.keys;
  const robots = Object.keys(drives);
  $("robot").replaceChildren(...robots.map((name) => new Option(name, name)));
  if (robots.includes(chosen)) $("robot").value = chosen;
  $("driving").hidden = $("speeds").hidden = robots.length === 0;
  $("pad").hidden = robots.length === 0 && !read;
  show();
});

onSelect(() => {
  if (!(selected.robot in drives) || $("robot").value === selected.robot) return;
  release();
  $("robot").value = selected.robot;
  show();
});

const isOn = () => $("wheel").getAttribute("aria-pressed") === "true";

// Returns OmniGraph's name of a key; undefined for a key that it does not have.
function nameOf(code) {
  if (/^Key[A-Z]$/.test(code)) return code.slice(3);
  if (/^Digit\d$/.test(code)) return `Key${code.slice(5)}`;
  if (/^Arrow/.test(code)) return code.slice(5);
  return /^(F\d\d?|Numpad\d)$/.test(code) ? code : NAMES[code];
}

function drive() {
  const topic = drives[$("robot").value], ways = [...held].map((code) => WAYS[code]).filter(Boolean);
  if (topic) {
    const [ahead, turn] = ways.reduce((sum, way) => [sum[0] + way[0], sum[1] + way[1]], [0, 0]);
    if (ways.length) ask({ ask: "drive", topic, twist: [ahead * Number($("speed-ahead").value), 0, turn * Number($("speed-turn").value)] });
    else if (driving) ask({ ask: "drive", topic, twist: null });
    driving = ways.length > 0;
  }
  if (read && (held.size || sent)) ask({ ask: "keys", down: [...held].map(nameOf).filter(Boolean) });
  sent = held.size > 0;
  show();
}

function show() {
  const target = Object.keys(drives).length ? `Drive ${$("robot").value} with W A S D` : "Send keys to the graphs";
  put($("wheel"), isOn() ? "Keyboard on" : target);
  $("keys").hidden = !isOn();
  for (const key of $("keys").querySelectorAll("[data-code]")) key.classList.toggle("held", held.has(key.dataset.code));
  put($("held"), [...held].map((code) => nameOf(code) ?? code).join(" "));
  for (const name of ["ahead", "turn"]) put($(`shown-${name}`), Number($(`speed-${name}`).value).toFixed(2));
}

function release() {
  held.clear();
  drive();
}

function press(event) {
  const used = event.code in WAYS && Object.keys(drives).length || read && nameOf(event.code);
  if (!isOn() || !used || event.repeat && held.has(event.code)) {
    if (isOn() && used && event.repeat) event.preventDefault();
    return;
  }
  if (event.altKey || event.metaKey || event.ctrlKey && event.code !== "ControlLeft" || event.target.closest?.("input:not([type=range]), select, textarea")) return;
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
  $("wheel").setAttribute("aria-pressed", String(!isOn()));
  release();
};
$("robot").onchange = release;
for (const name of ["ahead", "turn"]) $(`speed-${name}`).oninput = drive;
for (const [code, sign, name] of [["KeyW", "W", "forward"], ["KeyA", "A", "to the left"], ["KeyS", "S", "back"], ["KeyD", "D", "to the right"]]) {
  const key = element("button", sign, "key-cap", { type: "button", "data-code": code, title: name, "aria-label": `drive ${name}` });
  key.onpointerdown = (event) => { event.preventDefault(); held.add(code); drive(); };
  key.onpointerup = key.onpointerleave = key.onpointercancel = () => { if (held.delete(code)) drive(); };
  $("caps").append(key);
}
document.addEventListener("visibilitychange", () => { if (document.hidden) release(); });
setInterval(() => { if (held.size) drive(); }, AGAIN);
