// The drawing of the selected graph: executed nodes, their cost, and their problems.
import { ask, on } from "./connection.js";
import { $, place, put } from "./elements.js";
import { onSelect, select, selected } from "./selection.js";

const SVG = "http://www.w3.org/2000/svg";
const SMALLEST = 0.62; // minimum scale of a drawing, at which text is legible; larger graphs are scrolled
let graphs = [], problems = {}, drawn = "";
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
  if (graph) ask({ ask: "look", graph: graph.name });
}

on("graph", (graph) => {
  if (graph.name !== selected.graph) return;
  details = graph;
  drawn = graph.name;
  $("drawing").innerHTML = graph.svg; // the run makes the SVG and escapes all names in it
  const picture = $("drawing").querySelector("svg");
  if (picture) {
    const { width, height } = picture.viewBox.baseVal;
    Object.assign(picture.style, { minWidth: `${width * SMALLEST}px`, minHeight: `${height * SMALLEST}px` });
  }
  for (const box of boxes()) prepare(box);
  if (!(selected.node in graph.nodes)) selected.node = "";
  markSelected();
  showProblems();
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
  box.append(drawing("text", { class: "cost", y: -5 }));
}

function drawing(kind, attributes, text = "") {
  const made = document.createElementNS(SVG, kind);
  for (const key in attributes) made.setAttribute(key, attributes[key]);
  made.textContent = text;
  return made;
}

function markSelected() {
  for (const box of boxes()) box.classList.toggle("selected", box.dataset.node === selected.node);
}

on("frame", ({ nodes }) => {
  const runs = nodes[drawn] ?? {};
  for (const box of boxes()) {
    const [ran, , cost] = runs[box.dataset.node] ?? [0, 0, 0];
    box.classList.toggle("ran", ran > 0);
    if (ran) put(box.querySelector(".cost"), `${cost.toFixed(1)} µs`);
  }
});

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
