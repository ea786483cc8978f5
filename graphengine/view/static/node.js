// The ports of the selected node and the variables of the selected graph, with live values; unwired inputs of a run are edited.
import { command, on, tell } from "./connection.js";
import { $, brief, element, note, place, put, putValue, showDetail, steady, valueCell } from "./elements.js";
import { details, graphFacts, problemOf } from "./graphs.js";
import { isPlotted, plot } from "./plots.js";
import { changePart, savePart } from "./save.js";
import { onSelect, selected } from "./selection.js";
import { onTab } from "./tabs.js";

on("graph", () => { if (!$("node-side").hidden) show(); });
on("stage", () => { if (!$("node-side").hidden) show(); });
on("problems", () => showProblem());
on("plots", markPlotted);
onTab((name) => { if (name === "graph") { show(); showDetail("node-side"); } });
onSelect((what) => {
  if (what === "robot" || what === "stage") return;
  show();
  showDetail("node-side");
  const row = what.startsWith("variable:") && $("node-side").querySelector(`[data-port="${CSS.escape(what)}"]`);
  if (row) row.scrollIntoView({ block: "nearest" });
});

function show() {
  const node = details.nodes[selected.node];
  if (node) showNode(selected.node, node);
  else showGraph(graphFacts());
  markPlotted();
}

function showNode(name, facts) {
  const table = element("table");
  for (const side of ["inputs", "outputs", "state"]) {
    const ports = facts.ports.filter((one) => one.side === side);
    if (ports.length) table.append(sideRow(side), ...ports.flatMap((one) => portRow(name, one)));
  }
  const problem = element("div", "", "problem-box", { id: "problem" });
  $("node-side").replaceChildren(
    element("h2", name), note(facts.type), place(facts.place, facts.copy), changePart(), problem, table);
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
    place(graph.file, graph.copy), table,
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
  line.append(plotButton(line, name, name), valueCell());
  return line;
}

function portRow(name, one) {
  const line = element("tr", "", "", { "data-port": `${name}.${one.side}:${one.name}` });
  line.title = `${one.name}: ${one.type}${one.unit ? ` in ${one.unit}` : ""}${one.wired ? ", wired" : ""}`;
  const about = plotButton(line, one.name, `${name}.${one.name}`, one.unit);
  if (one.unit) about.append(element("span", ` ${one.unit}`, "unit"));
  const edited = one.side === "inputs" && !one.wired;
  line.append(about, edited ? element("td", "", "value") : valueCell());
  const rows = edited ? [line, edit(line, name, one)] : [line];
  if (one.doc) rows.push(docRow(one.doc));
  return rows;
}

function docRow(text) {
  const line = element("tr", "", "about");
  line.append(element("td", text, "doc", { colspan: 2 }));
  return line;
}

// Returns the expression that reads a port or a variable of the selected graph.
function expression(line) {
  const port = line.dataset.port, variable = port.startsWith("variable:");
  return variable ? `variable("${selected.graph}/${port.slice(9)}")` : `port("${selected.graph}/${port}")`;
}

function plotButton(line, name, label, unit) {
  const cell = element("td"), choose = element("button", "", "plain", { type: "button", title: `plot ${name}` });
  for (const word of name.split(/(?=[A-Z])/)) choose.append(word, element("wbr")); // a long name may break there
  choose.onclick = () => plot(expression(line), label, unit);
  cell.append(choose);
  return cell;
}

function edit(line, name, one) {
  const field = element("input", "", "", { size: 14, "aria-label": one.name });
  const wrong = element("tr", "", "refused", { hidden: "" }), reason = element("td", "", "", { role: "alert", colspan: 2 });
  if (document.body.classList.contains("replayed"))
    Object.assign(field, { disabled: true, title: "a recording cannot be changed" });
  field.onkeydown = (event) => {
    if (event.key === "Escape") { delete field.dataset.typed; wrong.hidden = true; field.blur(); }
    if (event.key === "Enter") setValue();
  };
  // A typed value is set also when Tab or a click leaves the field; a refused one stays, beside the reason.
  const address = `${selected.graph}/${name}.${one.name}`, edited = element("span", "", "edited");
  field.oninput = () => { field.dataset.typed = "true"; };
  field.onblur = () => setValue();
  async function setValue() {
    if (!field.dataset.typed) return;
    delete field.dataset.typed;
    let value = field.value;
    try { value = JSON.parse(value); } catch { /* a string */ }
    const { error } = await command("set", { address, value }, true);
    wrong.hidden = !error;
    put(reason, error ?? "");
    field.toggleAttribute("aria-invalid", Boolean(error));
    if (error) field.dataset.typed = "refused";
    else edited.replaceChildren(savePart(address));
    if (error && !field.isConnected) tell("notice", error); // another node is shown meanwhile
  }
  wrong.append(reason);
  line.children[1].append(field, edited);
  return wrong;
}

function markPlotted() {
  for (const line of $("node-side").querySelectorAll("[data-port]")) line.classList.toggle("plotted", isPlotted(expression(line)));
}

on("frame", ({ values }) => {
  const own = values[selected.graph] ?? {};
  if ($("node-side").hidden) return;
  for (const line of $("node-side").querySelectorAll("[data-port]")) {
    const value = own[line.dataset.port], text = String(brief(value)), field = line.querySelector("input");
    if (!field) putValue(line.children[1], steady(value), String(value ?? ""));
    else if (document.activeElement !== field && !field.dataset.typed && field.value !== text) field.value = text;
  }
});
