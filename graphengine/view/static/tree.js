// The tree of prims: robots with graphs and sensors, graphs with variables. The other panes show the selected item.
import { on } from "./connection.js";
import { $, brief, element, put } from "./elements.js";
import { onSelect, select, selected, selectRobot } from "./selection.js";
import { showTab } from "./tabs.js";

const FEW_ROBOTS = 3; // up to this number, robots are unfolded at first
const items = new Map(); // by key, in the order of the tree
const unfolded = new Map(); // items that the viewer unfolded (true) or folded (false), by key
let problems = {};

on("stage", ({ title, graphs, robots, objects }) => {
  items.clear();
  const few = robots.length <= FEW_ROBOTS;
  const own = graphs.filter((one) => !one.robot);
  const tops = robots.map((robot) => {
    const parts = graphs.filter((one) => one.robot === robot.name).map((one) => graphItem(one, 2));
    if (robot.sensors.length) parts.push(sensorGroup(robot));
    return item(`robot:${robot.name}`, robot.name, robot.spawned ? "spawned" : "robot", 1, robot.prim,
      () => selectRobot(robot.name), parts, few);
  });
  if (own.length)
    tops.unshift(item("scene", title, "scene", 1, "/", null, own.map((one) => graphItem(one, 2)), few));
  if (objects.length) tops.push(item("objects", `${objects.length} objects`, "folder", 1, "/", null,
    objects.map((name) => item(`robot:${name}`, name, "object", 2, name, () => selectRobot(name), []))));
  $("tree").replaceChildren(...tops.map((top) => top.line));
  const names = [...robots.map((one) => one.name), ...objects];
  if (!names.includes(selected.robot)) select("stage", { robot: robots.length === 1 ? robots[0].name : "" });
  const known = graphs.some((one) => one.name === selected.graph);
  if (!known) select("stage", { graph: graphs.at(-1)?.name ?? "", node: "" });
  mark();
  filter();
  showProblems();
});

function graphItem(graph, level) {
  const variables = graph.variables.map((name) => item(`variable:${graph.name}/${name}`, name, "variable", level + 1,
    `${graph.name}/${name}`, () => pickGraph(graph, name), []));
  return item(`graph:${graph.name}`, graph.short, "graph", level, graph.prim, () => pickGraph(graph), variables, true,
    graph.name);
}

function pickGraph({ name, robot }, variable = "") {
  showTab("graph");
  select(variable ? `variable:${variable}` : "graph", { graph: name, node: "", robot: robot || selected.robot });
}

function sensorGroup(robot) {
  const pick = () => selectRobot(robot.name);
  const sensors = robot.sensors.map((one) => item(`sensor:${one.prim}`, shortened(one.name), one.kind, 3, one.prim, pick, [], false, one.name));
  return item(`sensors:${robot.name}`, `${sensors.length} sensors`, "folder", 2, robot.prim, null, sensors);
}

// Sensors of one rig often differ only at the end of their names.
const shortened = (name) => (name.length > 20 ? `${name.slice(0, 6)}…${name.slice(-11)}` : name);

// Creates an item: `open` is whether it is unfolded at first, `words` are search terms for the filter.
function item(key, label, kind, level, prim, pick, children, open = false, words = label) {
  const line = element("li", "", "", { role: "treeitem", "aria-level": level, "aria-label": `${kind} ${label}`, tabindex: -1 });
  const row = element("div", "", `item ${kind}`, { title: prim });
  row.style.paddingLeft = `${(level - 1) * 14 + 4}px`;
  const fold = element("span", children.length ? "▸" : "", "fold", { "aria-hidden": "true" });
  row.append(fold, element("span", label, "label"), element("span", "", "now"), element("span", kind, "kind"),
    element("span", "", "badge"));
  line.append(row);
  const made = { key, line, row, pick, children, parent: null, prim, found: `${words} ${prim} ${kind}`.toLowerCase() };
  if (children.length) {
    const group = element("ul", "", "", { role: "group" });
    group.append(...children.map((child) => child.line));
    line.append(group);
    for (const child of children) child.parent = made;
  }
  fold.onclick = (event) => { event.stopPropagation(); unfold(made, !isUnfolded(made)); };
  row.onclick = () => { focus(made); pickItem(made); };
  items.set(key, made);
  made.open = unfolded.get(key) ?? open;
  showFold(made, made.open);
  return made;
}

const isUnfolded = (one) => one.line.getAttribute("aria-expanded") === "true";

function showFold(one, open) {
  if (one.children.length) one.line.setAttribute("aria-expanded", String(open));
}

function unfold(one, open) {
  one.open = open;
  unfolded.set(one.key, open);
  showFold(one, open);
}

function pickItem(one) {
  if (one.pick) one.pick();
  else unfold(one, !isUnfolded(one));
}

// Keyboard control as in the ARIA pattern for trees: one item has the focus, the arrow keys move it.
function shownItems() {
  return [...$("tree").querySelectorAll("[role=treeitem]")]
    .filter((line) => line.offsetParent !== null)
    .map((line) => [...items.values()].find((one) => one.line === line));
}

function focus(one) {
  for (const other of items.values()) other.line.tabIndex = other === one ? 0 : -1;
  one.line.focus();
}

$("tree").onkeydown = (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  const shown = shownItems(), at = shown.findIndex((one) => one.line === document.activeElement), one = shown[at];
  if (!one) return;
  const moves = {
    ArrowDown: () => shown[at + 1] && focus(shown[at + 1]),
    ArrowUp: () => shown[at - 1] && focus(shown[at - 1]),
    Home: () => focus(shown[0]),
    End: () => focus(shown.at(-1)),
    ArrowRight: () => (one.children.length && !isUnfolded(one) ? unfold(one, true) : one.children[0] && focus(one.children[0])),
    ArrowLeft: () => (one.children.length && isUnfolded(one) ? unfold(one, false) : one.parent && focus(one.parent)),
    Enter: () => pickItem(one),
    " ": () => pickItem(one),
  };
  if (!moves[event.key]) return;
  event.preventDefault();
  event.stopPropagation(); // elsewhere, these keys control the playback of a recording
  moves[event.key]();
};

// The filter: an item stays visible if all words match it together with its ancestors, or match a descendant.
function filter() {
  const words = $("filter").value.toLowerCase().split(/\s+/).filter(Boolean);
  const look = (one, above) => {
    const text = `${above} ${one.found}`;
    const hit = words.every((word) => text.includes(word));
    const below = one.children.map((child) => look(child, text)).some(Boolean);
    one.line.hidden = !hit && !below;
    if (words.length) showFold(one, below && one.children.some((child) => !child.line.hidden));
    else showFold(one, one.open);
    return hit || below;
  };
  const tops = [...items.values()].filter((one) => !one.parent).map((one) => look(one, ""));
  $("no-match").hidden = tops.some(Boolean) || !tops.length;
}

$("filter").oninput = filter;
$("filter").onkeydown = (event) => {
  if (event.key === "ArrowDown") { event.preventDefault(); if (shownItems()[0]) focus(shownItems()[0]); }
  if (event.key === "Escape") { $("filter").value = ""; filter(); }
};

// Highlights the current selection; the item of the selected graph can be focused with Tab.
function mark() {
  let target = null;
  for (const one of items.values()) {
    const chosen = one.key === `graph:${selected.graph}` || one.key === `robot:${selected.robot}`;
    one.line.setAttribute("aria-selected", String(chosen));
    one.row.classList.toggle("selected", chosen);
    if (one.key === `graph:${selected.graph}`) target = one;
    one.line.tabIndex = -1;
    if (chosen && one.key.startsWith("robot:")) one.row.scrollIntoView({ block: "nearest" });
  }
  (target ?? [...items.values()].find((one) => !one.parent) ?? { line: {} }).line.tabIndex = 0;
}

onSelect(mark);

on("frame", ({ values }) => {
  const live = values[selected.graph] ?? {};
  for (const [key, one] of items) {
    if (!key.startsWith("variable:")) continue;
    const own = `variable:${selected.graph}/`;
    put(one.row.querySelector(".now"), key.startsWith(own) ? String(brief(live[`variable:${key.slice(own.length)}`], 4)) : "");
  }
});

// Shows the number of node problems at graphs and their robots.
on("problems", (found) => {
  problems = found;
  showProblems();
});

function showProblems() {
  const counts = new Map(), failing = new Set();
  for (const one of items.values()) {
    if (!one.key.startsWith("graph:")) continue;
    for (const [path, { count, severity }] of Object.entries(problems)) {
      if (!path.startsWith(`${one.prim}/`)) continue;
      for (const above of [one, one.parent].filter(Boolean)) {
        counts.set(above, (counts.get(above) ?? 0) + count);
        if (severity === "error") failing.add(above);
      }
    }
  }
  for (const one of items.values()) {
    const count = counts.get(one) ?? 0, badge = one.row.querySelector(".badge");
    put(badge, count ? String(count) : "");
    badge.classList.toggle("error", failing.has(one));
    badge.title = count ? `${count} problems of nodes` : "";
  }
}
