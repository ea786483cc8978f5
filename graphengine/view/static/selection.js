// The selected graph, node, and robot or object. One selection a viewer: tree, drawing, 3D part and details follow it.
import { ask, on } from "./connection.js";

export const selected = { graph: linked.get("graph") ?? "", node: linked.get("node") ?? "", robot: linked.get("robot") ?? "" };
const listeners = [];
let graphs = [], told = "";

export function onSelect(take) {
  listeners.push(take);
}

// Changes the selection; `what` is the kind of item that the user selected.
export function select(what, names) {
  Object.assign(selected, names);
  for (const take of listeners) take(what);
  link({ ...selected });
  if (selected.robot === told) return;
  told = selected.robot;
  ask({ ask: "select", robot: told });
}

// Puts parts of a link into the address of the page.
export function link(parts) {
  for (const name in parts) {
    if (parts[name]) linked.set(name, parts[name]);
    else linked.delete(name);
  }
  history.replaceState(null, "", linked.size ? `#${linked}` : location.pathname);
}

// Selects a robot or object, and the graph of the robot that is called like the selected graph of another robot.
export function selectRobot(name) {
  const own = graphs.filter((one) => one.robot === name), now = graphs.find((one) => one.name === selected.graph);
  const twin = own.find((one) => one.short === now?.short) ?? own[0];
  const keeps = !twin || !now || now.robot === name;
  select("robot", keeps ? { robot: name } : { robot: name, graph: twin.name });
}

on("stage", (stage) => { graphs = stage.graphs; });
on("open", () => { if (selected.robot) ask({ ask: "select", robot: selected.robot }); });
on("picked", selectRobot);
