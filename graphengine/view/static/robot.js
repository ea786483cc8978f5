// The selected robot: its pose, velocity and details; spawning and deleting robots.
import { command, on } from "./connection.js";
import { $, button, element, note, put, showDetail } from "./elements.js";
import { onSelect, select, selected } from "./selection.js";
import { showTopicsOf } from "./topics.js";

const NUMBERS = [["x", "x", "m"], ["y", "y", "m"], ["z", "z", "m"], ["heading", "heading", "°"],
  ["speed", "speed", "m/s"], ["turn", "turn rate", "rad/s"]];
let robots = [], newest = {};

on("stage", (stage) => {
  robots = stage.robots;
  $("uses").replaceChildren(...[...new Set(robots.map((one) => one.use).filter(Boolean))].map((use) => new Option(use, use)));
  if (!$("robot-side").hidden) show();
});
onSelect((what) => { if (what === "robot") { show(); showDetail("robot-side"); } });

function show() {
  const robot = robots.find((one) => one.name === selected.robot);
  if (!robot) {
    $("robot-side").replaceChildren(element("p", "This robot was removed.", "hint"));
    return;
  }
  const table = element("table");
  for (const [key, label, unit] of NUMBERS) {
    const line = element("tr"), name = element("td", label);
    name.append(element("span", ` ${unit}`, "unit"));
    line.append(name, element("td", "", "value", { "data-number": key }));
    table.append(line);
  }
  const actions = element("div", "", "actions");
  actions.append(button("Show topics", () => showTopicsOf(robot.namespace)));
  if (robot.spawned) actions.append(button("Delete", () => remove(robot.name), "danger"));
  const facts = [`prim ${robot.prim}`, `namespace ${robot.namespace ? `/${robot.namespace}` : "none"}`, robot.use && `file ${robot.use}`];
  $("robot-side").replaceChildren(element("h2", robot.name),
    ...facts.filter(Boolean).map(note), table, actions);
  showNumbers();
}

on("frame", (frame) => {
  newest = frame.robots;
  if (!$("robot-side").hidden) showNumbers();
});

function showNumbers() {
  const state = newest[selected.robot] ?? {};
  for (const cell of $("robot-side").querySelectorAll("[data-number]")) {
    const value = state[cell.dataset.number];
    put(cell, typeof value === "number" ? value.toFixed(3).replace(/^-(0\.0+)$/, "$1") : "");
  }
}

async function remove(name) {
  const answer = await command("delete", { name });
  if (!answer.error) select("robot", { robot: "" });
}

// Spawning: the run looks up the file as it does for `use` in a scene file.
$("spawn").onclick = () => {
  put($("spawn-error"), "");
  const names = robots.map((one) => one.name);
  let number = 2;
  while (names.includes(`robot_${number}`)) number += 1;
  $("spawn-name").value = `robot_${number}`;
  $("spawn-namespace").value = `robot_${number}`;
  $("spawn-use").value ||= robots[0]?.use ?? "";
  const beside = newest[selected.robot];
  if (beside) { // a metre to the side of the selected robot
    $("spawn-x").value = (beside.x + 1).toFixed(2);
    $("spawn-y").value = beside.y.toFixed(2);
  }
  $("spawn-dialog").showModal();
};
$("spawn-name").oninput = () => { $("spawn-namespace").value = $("spawn-name").value; };
$("spawn-cancel").onclick = () => $("spawn-dialog").close();
$("spawn-form").onsubmit = async (event) => {
  event.preventDefault();
  const [x, y, z, heading] = ["x", "y", "z", "heading"].map((key) => Number($(`spawn-${key}`).value));
  const use = { use: $("spawn-use").value, position: [x, y, z], orientation: { rpy_deg: [0, 0, heading] } };
  if ($("spawn-namespace").value) use.namespace = $("spawn-namespace").value;
  const name = $("spawn-name").value, answer = await command("spawn", { name, use, force: $("spawn-force").checked });
  put($("spawn-error"), answer.error ?? "");
  if (answer.error) return;
  $("spawn-dialog").close();
  select("robot", { robot: name });
};
