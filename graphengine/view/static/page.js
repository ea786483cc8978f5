// The page of a run: control, graphs with live values, and the keyboard that drives. The world in 3D is a frame of its own.
const $ = (id) => document.getElementById(id);
const SECONDS = 30; // of a plot

let socket, stage, frame, asked = 0;
let graph = null, node = null, port = null;
const answers = new Map();
const plot = [];

function connect() {
  const url = new URL("feed", location.href);
  url.protocol = url.protocol.replace("http", "ws");
  socket = new WebSocket(url);
  socket.onmessage = (event) => {
    const told = JSON.parse(event.data);
    if (told.stage) showStage(told.stage);
    if (told.frame) showFrame(told.frame);
    if (told.answer) (answers.get(told.answer.id) ?? (() => {}))(told.answer);
  };
  socket.onopen = () => { if (graph) ask({ ask: "look", graph: graph.name }); };
  socket.onclose = () => {
    $("state").textContent = "disconnected";
    $("state").className = "state failed";
    setTimeout(connect, 1000);
  };
}

function ask(what) {
  if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(what));
}

function command(name, args = {}) {
  const id = ++asked;
  answers.set(id, (answer) => {
    answers.delete(id);
    $("message").textContent = answer.error ?? "";
  });
  ask({ ask: "command", id, command: name, arguments: args });
}

// Stage

function showStage(told) {
  stage = told;
  document.title = `${told.title} - graphrun`;
  $("title").textContent = told.title;
  const robots = Object.keys(told.drives);
  $("robot").replaceChildren(...robots.map((name) => new Option(name, name)));
  $("driving").hidden = $("wheel").hidden = robots.length === 0;
  $("graphs").replaceChildren(...told.graphs.map(tab));
  select(told.graphs.find((one) => one.name === graph?.name) ?? told.graphs[told.graphs.length - 1]);
}

function tab(one) {
  const button = document.createElement("button");
  button.setAttribute("role", "tab");
  button.textContent = one.name;
  button.onclick = () => select(one);
  return button;
}

function select(one) {
  graph = one;
  for (const button of $("graphs").children)
    button.setAttribute("aria-selected", String(button.textContent === one?.name));
  $("drawing").innerHTML = one?.svg ?? "";
  for (const box of $("drawing").querySelectorAll("[data-node]")) {
    box.addEventListener("click", () => selectNode(box.dataset.node));
    const cost = document.createElementNS("http://www.w3.org/2000/svg", "text");
    cost.setAttribute("class", "cost");
    cost.setAttribute("y", "-5");
    box.append(cost);
  }
  selectNode(node in (one?.nodes ?? {}) ? node : null);
  if (one) ask({ ask: "look", graph: one.name });
}

function selectNode(name) {
  node = name;
  port = null;
  plot.length = 0;
  for (const box of $("drawing").querySelectorAll("[data-node]"))
    box.classList.toggle("selected", box.dataset.node === name);
  if (!name) {
    $("side").innerHTML = '<p class="hint">Select a node of the graph to see its ports.</p>';
    return;
  }
  const facts = graph.nodes[name];
  const table = document.createElement("table");
  for (const side of ["inputs", "outputs", "state"]) {
    const ports = facts.ports.filter((one) => one.side === side);
    if (ports.length) table.append(sideRow(side), ...ports.map((one) => portRow(name, one)));
  }
  const head = document.createElement("h2");
  head.textContent = name;
  const type = document.createElement("p");
  type.className = "place";
  type.textContent = facts.type;
  const place = document.createElement("p");
  place.className = "place";
  place.textContent = facts.place;
  const canvas = document.createElement("canvas");
  canvas.hidden = true;
  $("side").replaceChildren(head, type, place, canvas, element("p", "", "place caption"), table);
}

function element(kind, text, className = "") {
  return Object.assign(document.createElement(kind), { textContent: text, className });
}

function sideRow(side) {
  const line = document.createElement("tr");
  const head = element("th", side);
  head.colSpan = 2;
  line.append(head);
  return line;
}

function portRow(name, one) {
  const line = document.createElement("tr");
  line.dataset.port = `${name}.${one.side}:${one.name}`;
  line.title = `${one.name}: ${one.type}${one.unit ? ` in ${one.unit}` : ""}${one.wired ? ", wired" : ""}`;
  const about = element("td", one.name);
  if (one.unit) about.append(element("span", ` ${one.unit}`, "unit"));
  if (one.doc) about.append(element("div", one.doc, "doc"));
  line.append(about, element("td", "", "value"));
  if (one.side === "inputs" && !one.wired) edit(line, name, one);
  else line.addEventListener("click", () => choosePlot(line));
  return line;
}

function edit(line, name, one) {
  const field = Object.assign(document.createElement("input"), { size: 14 });
  field.setAttribute("aria-label", one.name);
  field.onkeydown = (event) => {
    if (event.key !== "Enter") return;
    let value = field.value;
    try { value = JSON.parse(value); } catch { /* a text */ }
    command("set", { address: `${graph.name}/${name}.${one.name}`, value });
    field.blur();
  };
  line.children[1].append(field);
}

function choosePlot(line) {
  port = line.dataset.port;
  plot.length = 0;
  for (const other of $("side").querySelectorAll("tr")) other.classList.toggle("plotted", other === line);
}

// Frames

function showFrame(told) {
  frame = told;
  const facts = told.facts;
  $("time").textContent = `${facts.time.toFixed(2)} s`;
  $("state").textContent = facts.state;
  $("state").className = `state ${facts.state}`;
  $("rate").textContent = `x${facts.rate.toFixed(2)}`;
  const pace = facts.pace === null ? "max" : String(facts.pace);
  if (document.activeElement !== $("pace")) $("pace").value = pace;
  if (graph) showGraph(told.nodes[graph.name] ?? {}, told.values[graph.name] ?? {});
}

function showGraph(runs, values) {
  for (const box of $("drawing").querySelectorAll("[data-node]")) {
    const [ran, , cost] = runs[box.dataset.node] ?? [0, 0, 0];
    box.classList.toggle("ran", ran > 0);
    if (ran) box.querySelector(".cost").textContent = `${cost.toFixed(1)} µs`;
  }
  for (const line of $("side").querySelectorAll("[data-port]")) {
    const value = values[line.dataset.port];
    const text = typeof value === "number" ? String(+value.toPrecision(6)) : (value ?? "");
    const field = line.querySelector("input");
    if (!field) line.children[1].textContent = text;
    else if (document.activeElement !== field) field.value = text;
  }
  const value = values[port];
  if (typeof value === "number") drawPlot(value);
}

function drawPlot(value) {
  plot.push([frame.facts.time, value]);
  while (plot.length && plot[0][0] < frame.facts.time - SECONDS) plot.shift();
  const canvas = $("side").querySelector("canvas");
  canvas.hidden = false;
  const [wide, high] = [(canvas.width = canvas.clientWidth), (canvas.height = canvas.clientHeight)];
  const numbers = plot.map(([, number]) => number);
  const [low, top] = [Math.min(...numbers), Math.max(...numbers)];
  const context = canvas.getContext("2d");
  const style = getComputedStyle(document.documentElement);
  context.strokeStyle = style.getPropertyValue("--strong");
  context.beginPath();
  for (const [time, number] of plot) {
    const x = wide * (1 - (frame.facts.time - time) / SECONDS);
    const y = high - 6 - (high - 12) * (top > low ? (number - low) / (top - low) : 0.5);
    context.lineTo(x, y);
  }
  context.stroke();
  const range = `${+low.toPrecision(4)} to ${+top.toPrecision(4)}`;
  $("side").querySelector(".caption").textContent = `${port}: ${range} in the last ${SECONDS} s`;
}

// Control

$("play").onclick = () => command("play");
$("pause").onclick = () => command("pause");
$("step").onclick = () => command("step");
$("reset").onclick = () => command("reset");
$("pace").onchange = () => command("rate", { factor: $("pace").value === "max" ? "max" : Number($("pace").value) });

// The keyboard drives while a key is held down; a released key, a lost focus and a hidden page stop the robot.
const KEYS = { KeyW: [0.5, 0, 0], ArrowUp: [0.5, 0, 0], KeyS: [-0.5, 0, 0], ArrowDown: [-0.5, 0, 0],
  KeyA: [0, 0, 1], ArrowLeft: [0, 0, 1], KeyD: [0, 0, -1], ArrowRight: [0, 0, -1] };
const held = new Set();
let driving = false;

function drive() {
  const topic = stage?.drives[$("robot").value];
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
  const on = $("wheel").getAttribute("aria-pressed") !== "true";
  $("wheel").setAttribute("aria-pressed", String(on));
  if (!on) release();
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

$("world").src = matchMedia("(prefers-color-scheme: dark)").matches ? "3d/?darkMode" : "3d/";
connect();
