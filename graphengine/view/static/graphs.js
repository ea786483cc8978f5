// The drawing of the selected graph: executed nodes with their order and cost, set values, wires of the selected node, and problems.
import { ask, on } from "./connection.js";
import { $, brief, copyButton, place, put } from "./elements.js";
import { PanZoom } from "./pan_zoom.js";
import { onSelect, select, selected } from "./selection.js";

const SVG = "http://www.w3.org/2000/svg";
const STEADY = 0.9; // share of the former cost in the shown one, which would flicker otherwise
const view = new PanZoom($("drawing"));
let graphs = [], problems = {}, drawn = "", found = [], at = -1;
let costs = {}, set = {}; // mean computing times, µs, by node; values of ports when the graph was drawn
export let details = { nodes: {} }; // details of the selected graph

export const graphFacts = () => graphs.find((one) => one.name === selected.graph);
export const problemOf = (node) => problems[`${graphFacts()?.prim}/${node}`];

on("stage", (stage) => {
  graphs = stage.graphs;
  look();
});
on("open", look);
onSelect((what) => {
  if (selected.graph !== drawn) look();
  if (what === "node") markSelected();
});

function look() {
  const graph = graphFacts();
  $("graph-file").replaceChildren(...(graph ? [place(graph.file, graph.copy)] : []));
  $("graph-link").hidden = !graph;
  if (graph) ask({ ask: "look", graph: graph.name });
}

on("graph", (graph) => {
  if (graph.name !== selected.graph) return;
  details = graph;
  const same = drawn === graph.name;
  drawn = graph.name;
  costs = {};
  set = {};
  $("drawing").innerHTML = graph.svg; // the run makes the SVG and escapes all names in it
  const picture = $("drawing").querySelector("svg");
  if (picture) view.show(picture, same);
  for (const box of boxes()) prepare(box);
  if (!(selected.node in graph.nodes)) selected.node = "";
  markSelected();
  showProblems();
  search();
});

const boxes = () => $("drawing").querySelectorAll("[data-node]");

function prepare(box) {
  const name = box.dataset.node;
  const attributes = { tabindex: 0, role: "button", "aria-label": `node ${name}` };
  for (const key in attributes) box.setAttribute(key, attributes[key]);
  box.onclick = () => select("node", { node: name });
  box.onkeydown = (event) => {
    if (event.key !== "Enter" && event.key !== " ") return;
    event.preventDefault();
    select("node", { node: name });
  };
  const cost = drawing("text", { class: "cost", y: -5 });
  cost.append(drawing("tspan", { class: "order" }), drawing("tspan", {}));
  box.append(cost);
}

function drawing(kind, attributes, text = "") {
  const made = document.createElementNS(SVG, kind);
  for (const key in attributes) made.setAttribute(key, attributes[key]);
  made.textContent = text;
  return made;
}

// Marks the selected node and lights its wires.
function markSelected() {
  for (const box of boxes()) {
    box.classList.toggle("selected", box.dataset.node === selected.node);
    if (box.dataset.node === selected.node) view.reveal(box);
  }
  for (const wire of $("drawing").querySelectorAll(".connection"))
    wire.classList.toggle("lit", Boolean(selected.node) && [wire.dataset.from, wire.dataset.to].includes(selected.node));
}

on("frame", ({ nodes, values }) => {
  const runs = nodes[drawn] ?? {};
  for (const box of boxes()) {
    const name = box.dataset.node, [ran, , cost, order] = runs[name] ?? [0, 0, 0, 0];
    box.classList.toggle("ran", ran > 0);
    if (ran) costs[name] = name in costs ? STEADY * costs[name] + (1 - STEADY) * cost : cost;
    put(box.querySelector(".order"), ran ? `${order}. ` : "");
    put(box.querySelector(".cost tspan:last-child"), name in costs ? `${costs[name].toFixed(costs[name] < 100 ? 1 : 0)} µs` : "");
    showValues(box, values[drawn] ?? {});
  }
  const most = Math.max(1e-9, ...Object.values(costs));
  for (const box of boxes()) box.style.setProperty("--heat", `${Math.round((70 * (costs[box.dataset.node] ?? 0)) / most)}%`);
});

// Shows the values of inputs that were set since the graph was drawn.
function showValues(box, live) {
  for (const port of box.querySelectorAll("[data-port^='left:']")) {
    const text = port.querySelector(".value"), key = `${box.dataset.node}.inputs:${port.dataset.port.slice(5)}`;
    if (!text || !(key in live)) continue;
    set[key] ??= live[key];
    if (live[key] === set[key]) continue;
    set[key] = live[key];
    put(text, ` ${brief(live[key])}`);
    port.classList.add("changed");
  }
}

// The search: Enter goes from one node to the next whose name, type or ports contain all words.
function search() {
  const words = $("graph-find").value.toLowerCase().split(/\s+/).filter(Boolean);
  found = words.length ? [...boxes()].filter((box) => {
    const facts = details.nodes[box.dataset.node] ?? { type: "", ports: [] };
    const text = [box.dataset.node, facts.type, ...facts.ports.map((one) => one.name)].join(" ").toLowerCase();
    return words.every((word) => text.includes(word));
  }) : [];
  at = -1;
  for (const box of boxes()) box.classList.toggle("found", found.includes(box));
  put($("graph-found"), words.length ? `${found.length} found` : "");
}

function next(step) {
  if (!found.length) return;
  at = (at + step + found.length) % found.length;
  put($("graph-found"), `${at + 1} of ${found.length}`);
  select("node", { node: found[at].dataset.node });
}

$("graph-find").oninput = search;
$("graph-find").onkeydown = (event) => {
  if (event.key === "Enter") { event.preventDefault(); next(event.shiftKey ? -1 : 1); }
  if (event.key === "Escape") { $("graph-find").value = ""; search(); $("drawing").focus(); }
};
addEventListener("keydown", (event) => {
  if (event.code !== "KeyF" || !(event.ctrlKey || event.metaKey) || $("graph-pane").hidden) return;
  event.preventDefault();
  $("graph-find").select();
});
$("graph-in").onclick = () => view.zoom(1.25);
$("graph-out").onclick = () => view.zoom(0.8);
$("graph-fit").onclick = () => view.fit();
$("graph-heat").onclick = () => {
  const heat = $("drawing").classList.toggle("heat");
  $("graph-heat").setAttribute("aria-pressed", String(heat));
};
$("graph-link").append(copyButton(() => location.href, "copy a link to this graph and node", "link"));

on("problems", (found) => {
  problems = found;
  showProblems();
});

// The number of problems is shown at the corner of a node; the tooltip shows the last one.
function showProblems() {
  for (const box of boxes()) {
    const problem = problemOf(box.dataset.node);
    box.querySelector(".problem")?.remove();
    box.classList.toggle("troubled", Boolean(problem));
    if (!problem) continue;
    const count = String(problem.count), wide = 10 + 7 * count.length, right = Number(box.querySelector(".box").getAttribute("width"));
    const mark = drawing("g", { class: `problem ${problem.severity}`, transform: `translate(${right - wide + 6} -9)` });
    mark.append(drawing("title", {}, `${count} problems, the last: ${problem.text}`),
      drawing("rect", { width: wide, height: 18, rx: 9 }), drawing("text", { x: wide / 2, y: 13, "text-anchor": "middle" }, count));
    box.append(mark);
  }
}
