// The graphs of the run: their drawings, and the ports of the selected node.
import { ask, command, on } from "./connection.js";
import { $, element } from "./elements.js";
import { plot, plotArea, plotted } from "./plot.js";

let graph = null, node = null;

on("open", () => { if (graph) ask({ ask: "look", graph: graph.name }); });

on("stage", ({ graphs }) => {
  $("graphs").replaceChildren(...graphs.map(tab));
  select(graphs.find((one) => one.name === graph?.name) ?? graphs[graphs.length - 1]);
});

on("frame", ({ facts, nodes, values }) => {
  if (graph) showGraph(nodes[graph.name] ?? {}, values[graph.name] ?? {}, facts.time);
});

function tab(one) {
  const button = element("button", one.name);
  button.setAttribute("role", "tab");
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
  plot(null);
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
  $("side").replaceChildren(
    element("h2", name), element("p", facts.type, "place"), element("p", facts.place, "place"), plotArea(), table);
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
  else line.addEventListener("click", () => choosePort(line));
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

function choosePort(line) {
  plot(line.dataset.port);
  for (const other of $("side").querySelectorAll("tr")) other.classList.toggle("plotted", other === line);
}

function showGraph(runs, values, time) {
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
  plotted(values, time);
}
