// The ports of the selected node and the variables of the selected graph, with live values; unwired inputs of a run are edited.
import { command, on } from "./connection.js";
import { $, brief, element, note, place, put, showDetail } from "./elements.js";
import { details, graphFacts, problemOf } from "./graphs.js";
import { plot, plotArea, plotted } from "./plot.js";
import { onSelect, selected } from "./selection.js";
import { onTab } from "./tabs.js";

on("graph", () => { if (!$("node-side").hidden) show(); });
on("stage", () => { if (!$("node-side").hidden) show(); });
on("problems", () => showProblem());
onTab((name) => { if (name === "graph") { show(); showDetail("node-side"); } });
onSelect((what) => {
  if (what === "robot") return;
  show();
  showDetail("node-side");
  const row = what.startsWith("variable:") && $("node-side").querySelector(`[data-port="${CSS.escape(what)}"]`);
  if (row) choosePort(row);
});

function show() {
  const port = $("node-side").querySelector(".plotted")?.dataset.port;
  plot(null);
  const node = details.nodes[selected.node];
  if (node) showNode(selected.node, node);
  else showGraph(graphFacts());
  const row = [...$("node-side").querySelectorAll("[data-port]")].find((one) => one.dataset.port === port);
  if (row) choosePort(row);
}

function showNode(name, facts) {
  const table = element("table");
  for (const side of ["inputs", "outputs", "state"]) {
    const ports = facts.ports.filter((one) => one.side === side);
    if (ports.length) table.append(sideRow(side), ...ports.map((one) => portRow(name, one)));
  }
  const problem = element("div", "", "problem-box", { id: "problem" });
  $("node-side").replaceChildren(
    element("h2", name), note(facts.type), place(facts.place, facts.copy), problem, plotArea(), table);
  showProblem();
}

function showGraph(graph) {
  if (!graph) {
    $("node-side").replaceChildren(element("p", "There are no graphs.", "hint"));
    return;
  }
  const table = element("table");
  if (graph.variables.length) table.append(sideRow("variables"), ...graph.variables.map(variableRow));
  $("node-side").replaceChildren(element("h2", graph.name), note(`prim ${graph.prim}`),
    place(graph.file, graph.copy), plotArea(), table,
    element("p", "Select a node of the graph to see its ports.", "hint"));
}

function showProblem() {
  const box = $("problem"), problem = selected.node && problemOf(selected.node);
  if (!box) return;
  box.hidden = !problem;
  if (!problem) return;
  box.className = `problem-box ${problem.severity}`;
  box.replaceChildren(element("b", `${problem.count} ${problem.count === 1 ? "problem" : "problems"}, the last:`), element("pre", problem.text));
}

function sideRow(side) {
  const line = element("tr");
  line.append(element("th", side, "", { colspan: 2, scope: "colgroup" }));
  return line;
}

function variableRow(name) {
  const line = element("tr", "", "", { "data-port": `variable:${name}` });
  line.append(plotButton(line, name), element("td", "", "value"));
  return line;
}

function portRow(name, one) {
  const line = element("tr", "", "", { "data-port": `${name}.${one.side}:${one.name}` });
  line.title = `${one.name}: ${one.type}${one.unit ? ` in ${one.unit}` : ""}${one.wired ? ", wired" : ""}`;
  const about = plotButton(line, one.name);
  if (one.unit) about.append(element("span", ` ${one.unit}`, "unit"));
  if (one.doc) about.append(element("div", one.doc, "doc"));
  line.append(about, element("td", "", "value"));
  if (one.side === "inputs" && !one.wired) edit(line, name, one);
  return line;
}

function plotButton(line, name) {
  const cell = element("td"), choose = element("button", "", "plain", { type: "button", title: `plot ${name}` });
  for (const word of name.split(/(?=[A-Z])/)) choose.append(word, element("wbr")); // a long name may break there
  choose.onclick = () => choosePort(line);
  cell.append(choose);
  return cell;
}

function edit(line, name, one) {
  const field = element("input", "", "", { size: 14, "aria-label": one.name });
  if (document.body.classList.contains("replayed"))
    Object.assign(field, { disabled: true, title: "a recording cannot be changed" });
  field.onkeydown = (event) => {
    if (event.key === "Escape") field.blur();
    if (event.key !== "Enter") return;
    let value = field.value;
    try { value = JSON.parse(value); } catch { /* a string */ }
    command("set", { address: `${selected.graph}/${name}.${one.name}`, value });
    field.blur();
  };
  line.children[1].append(field);
}

function choosePort(line) {
  plot(line.dataset.port);
  for (const other of $("node-side").querySelectorAll("tr")) other.classList.toggle("plotted", other === line);
}

on("frame", ({ facts, values }) => {
  const own = values[selected.graph] ?? {};
  if ($("node-side").hidden) return;
  for (const line of $("node-side").querySelectorAll("[data-port]")) {
    const text = String(brief(own[line.dataset.port]));
    const field = line.querySelector("input");
    if (!field) put(line.children[1], text);
    else if (document.activeElement !== field && field.value !== text) field.value = text;
  }
  plotted(own, facts.time);
});
