// The page: time bar, marks and log of a recording, around the 3D picture and the plots.

import { decode } from "./decode.js";
import { Plots } from "./plots.js";
import { World } from "./scene.js";

const SYMBOLS = { command: "◆", reset: "↺", error: "✕", contact: "●", verdict: "⚑" };
const element = (id) => document.getElementById(id);
const limited = (time) => Math.min(Math.max(time, 0), data.duration);

const data = await decode(element("data").textContent);
const state = { time: 0, playing: false, speed: 1 };
let world = null;
let drawn = false; // whether the picture shows the current state

function button(text, name, act) {
  const made = document.createElement("button");
  made.type = "button";
  made.append(text);
  if (name) made.title = made.ariaLabel = name;
  made.addEventListener("click", act);
  return made;
}

const clock = (time) => `${time.toFixed(2)} s`;

function seek(time) {
  state.time = limited(time);
  element("slider").value = state.time;
  element("slider").ariaValueText = element("time").textContent = clock(state.time);
  world?.show(state.time);
  plots.show(state.time);
  showLog();
  drawn = false;
}

function play(playing) {
  if (playing && state.time >= data.duration) seek(0);
  state.playing = playing;
  element("play").textContent = playing ? "❚❚" : "▶";
  element("play").title = element("play").ariaLabel = playing ? "Pause" : "Play";
}

// Selects the speed `step` places after the current one.
function changeSpeed(step) {
  const select = element("speed");
  select.selectedIndex = Math.min(Math.max(select.selectedIndex + step, 0), select.length - 1);
  state.speed = Number(select.value);
}

function addMarks() {
  for (const { time, kind, text } of data.marks) {
    const made = button(SYMBOLS[kind] ?? "▼", `${clock(time)}: ${text}`, () => seek(time));
    made.className = kind;
    made.style.left = `${(100 * time) / (data.duration || 1)}%`;
    element("marks").append(made);
  }
}

function addLog() {
  for (const { time, kind, text } of data.log) {
    const row = button("", "", () => seek(time));
    for (const [name, content] of [["when", clock(time)], [`kind ${kind}`, kind], ["text", text]]) {
      const part = row.appendChild(document.createElement("span"));
      part.className = name;
      part.textContent = content;
    }
    element("log").appendChild(document.createElement("li")).append(row);
  }
  element("log-part").hidden = data.log.length === 0;
}

// Marks the newest message that is not after the shown time.
function showLog() {
  const index = data.log.findLastIndex(({ time }) => time <= state.time + data.step / 2);
  if (index === state.entry) return;
  element("log").children[state.entry]?.removeAttribute("aria-current");
  state.entry = index;
  const row = element("log").children[index];
  row?.setAttribute("aria-current", "true");
  const list = element("log");
  list.scrollTop = row ? row.offsetTop - list.offsetTop - list.clientHeight / 2 : 0;
}

function addRobots() {
  const names = new Set(data.stages.flatMap((stage) => stage.robots.map(([name]) => name)));
  for (const name of names) element("follow").add(new Option(name, name, false, name === world.followed));
  element("follow-part").hidden = names.size === 0;
}

const KEYS = {
  " ": () => play(!state.playing),
  ArrowLeft: (event) => seek(state.time - (event.shiftKey ? 1 : data.step)),
  ArrowRight: (event) => seek(state.time + (event.shiftKey ? 1 : data.step)),
  ArrowUp: () => changeSpeed(1),
  ArrowDown: () => changeSpeed(-1),
  Home: () => seek(0),
  End: () => seek(data.duration),
};

function press(event) {
  const busy = event.target.matches("select, #plots") || (event.key === " " && event.target.matches("button"));
  if (busy || event.ctrlKey || event.altKey || event.metaKey || !KEYS[event.key]) return;
  event.preventDefault();
  KEYS[event.key](event);
}

let last = null;
function frame(now) {
  const passed = Math.min((now - (last ?? now)) / 1000, 0.25);
  last = now;
  if (state.playing) {
    seek(state.time + passed * state.speed);
    if (state.time >= data.duration) play(false);
  }
  if (!drawn) world?.render();
  drawn = true;
  requestAnimationFrame(frame);
}

const plots = new Plots(element("plots"), data.plots, data.duration, seek);
element("plots-part").hidden = data.plots.length === 0;
element("side").hidden = data.plots.length + data.log.length === 0;
try {
  world = await World.make(element("world"), data, () => (drawn = false));
  addRobots();
} catch (error) {
  element("no-world").hidden = false;
  element("no-world").textContent = `The 3D picture is missing: ${error.message}`;
}
addMarks();
addLog();
Object.assign(element("slider"), { max: data.duration, step: "any" });
element("duration").textContent = `of ${clock(data.duration)}`;
element("slider").addEventListener("input", () => seek(Number(element("slider").value)));
element("play").addEventListener("click", () => play(!state.playing));
element("speed").addEventListener("change", () => changeSpeed(0));
element("follow").addEventListener("change", () => {
  world.follow(element("follow").value);
  drawn = false;
});
document.addEventListener("keydown", press);
new ResizeObserver(() => (drawn = false)).observe(element("world"));
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => (drawn = false));
play(false);
seek(0);
requestAnimationFrame(frame);
window.recording = { state, data, seek, world };
