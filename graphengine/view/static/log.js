// The log: messages of nodes and of the session. A click on one selects its node.
import { on } from "./connection.js";
import { $, element, put } from "./elements.js";
import { select } from "./selection.js";
import { onTab, showTab } from "./tabs.js";

const MOST = 1000;
const rows = new Map(); // by level, node and text: a repeated message has one row
const LEVELS = ["info", "warning", "error"];
let graphs = [], last = 0;

on("stage", (stage) => { graphs = stage.graphs; });
on("log", (lines) => {
  const list = $("log"), atEnd = list.scrollTop + list.clientHeight > list.scrollHeight - 30;
  for (const line of lines) {
    if (line.number <= last) continue;
    last = line.number;
    const key = JSON.stringify([line.severity, line.node, line.text]);
    if (!rows.has(key)) { rows.set(key, row(line)); list.append(rows.get(key)); }
    const [when, , times] = rows.get(key).children;
    put(when, `${line.time.toFixed(2)} s`);
    put(times, line.count > 1 ? `× ${line.count}` : "");
  }
  for (const [key, made] of rows) if (rows.size > MOST) { rows.delete(key); made.remove(); }
  filter();
  if (atEnd) list.scrollTop = list.scrollHeight;
});
onTab((name) => { if (name === "log") $("log").scrollTop = $("log").scrollHeight; });

function row({ severity, node, text }) {
  const made = element("li", "", `line ${severity}`), where = graphOf(node);
  made.append(element("span", "", "when"), element("span", severity, "level"), element("span", "", "times"));
  if (where) {
    const choose = element("button", node.slice(where.prim.length + 1), "plain", { type: "button", title: `${node}: select this node` });
    choose.onclick = () => {
      const found = graphOf(node);
      if (!found) return;
      showTab("graph");
      select("node", { graph: found.name, node: node.slice(found.prim.length + 1), robot: found.robot });
    };
    made.append(choose);
  }
  made.append(element("span", text, "text"));
  made.dataset.words = `${severity} ${node} ${text}`.toLowerCase();
  return made;
}

// Returns the graph with a node; of nested prim paths, the longest.
function graphOf(node) {
  return graphs.filter((one) => node.startsWith(`${one.prim}/`)).sort((a, b) => b.prim.length - a.prim.length)[0];
}

function filter() {
  const words = $("log-filter").value.toLowerCase().split(/\s+/).filter(Boolean), least = LEVELS.indexOf($("log-level").value);
  let alerts = 0, failures = 0;
  for (const line of $("log").children) {
    const level = LEVELS.findIndex((one) => line.classList.contains(one));
    line.hidden = level < least || !words.every((word) => line.dataset.words.includes(word));
    alerts += level > 0;
    failures += level > 1;
  }
  put($("log-tab"), alerts ? `Log ${alerts}` : "Log");
  $("log-tab").classList.toggle("alert", failures > 0);
  $("no-log").hidden = last > 0;
}

$("log-filter").oninput = $("log-level").onchange = filter;
