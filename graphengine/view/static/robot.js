// The selected robot: its pose, velocity and details; spawning and deleting robots.
import { command, on } from "./connection.js";
import { $, button, element, note, put, putValue, showDetail, valueCell } from "./elements.js";
import { jointTable } from "./joints.js";
import { onSelect, select, selected } from "./selection.js";
import { showTopicsOf } from "./topics.js";
import { whyPart } from "./why.js";

const NUMBERS = [["x", "x", "m"], ["y", "y", "m"], ["z", "z", "m"], ["heading", "heading", "°"],
  ["speed", "speed", "m/s"], ["turn", "turn rate", "rad/s"]];
let robots = [], objects = [], newest = {}, joints = null;

on("stage", (stage) => {
  robots = stage.robots;
  objects = stage.objects;
  $("uses").replaceChildren(...[...new Set(robots.map((one) => one.use).filter(Boolean))].map((use) => new Option(use, use)));
  if (!$("robot-side").hidden) show();
});
onSelect((what) => { if (what === "robot") { show(); showDetail("robot-side"); } });

function show() {
  const robot = robots.find((one) => one.name === selected.robot), side = $("robot-side");
  joints = null;
  if (!robot && !objects.includes(selected.robot)) {
    side.replaceChildren(element("p", selected.robot ? "This robot was removed." : "Select a robot or an object.", "hint"));
    return;
  }
  const table = element("table"), actions = element("div", "", "actions");
  for (const [key, label, unit] of NUMBERS) {
    const line = element("tr"), name = element("td", label);
    name.append(element("span", ` ${unit}`, "unit"));
    line.append(name, valueCell("", { "data-number": key }));
    table.append(line);
  }
  if (robot) actions.append(button("Show topics", () => showTopicsOf(robot.namespace)));
  if (robot?.spawned) actions.append(button("Delete", () => remove(robot.name), "danger"));
  if (robot) joints = jointTable(robot);
  const facts = robot ? [`prim ${robot.prim}`, `namespace ${robot.namespace ? `/${robot.namespace}` : "none"}`, robot.use && `file ${robot.use}`] : [];
  side.replaceChildren(element("h2", selected.robot), ...facts.filter(Boolean).map(note),
    ...(robot ? [whyPart(robot.name)] : []), table, moveForm(selected.robot), actions, ...(joints?.parts ?? []));
  showNumbers();
}

// A form that puts the robot or object to a pose given in numbers.
function moveForm(name) {
  const form = element("form", "", "move live"), refusal = element("p", "", "refused", { role: "alert" });
  const fields = NUMBERS.slice(0, 4).map(([key, label, unit]) => element("input", "", "", { type: "number", step: "any", name: key,
    placeholder: key === "heading" ? unit : `${label}, ${unit}`, "aria-label": `${label}, ${unit}` }));
  form.append(...fields, element("button", "Move", "", { type: "submit", title: "move it to this pose; an empty field keeps the present value" }), refusal);
  form.onsubmit = async (event) => {
    event.preventDefault();
    const [x, y, z, heading] = fields.map((field) => (field.value === "" ? newest[name]?.[field.name] ?? 0 : Number(field.value)));
    const turned = fields[3].value === "" ? {} : { orientation: { rpy_deg: [0, 0, heading] } };
    const { error } = await command("move", { entity: name, position: [x, y, z], ...turned }, true);
    put(refusal, error ?? "");
    if (!error) form.reset();
  };
  return form;
}

on("frame", (frame) => {
  newest = frame.robots;
  if (!$("robot-side").hidden) showNumbers();
});

function showNumbers() {
  const state = newest[selected.robot] ?? {};
  for (const cell of $("robot-side").querySelectorAll("[data-number]")) {
    const value = state[cell.dataset.number];
    putValue(cell, typeof value === "number" ? value.toFixed(3).replace(/^-(0\.0+)$/, "$1") : "", String(value ?? ""));
  }
  joints?.show(state.joints ?? {});
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
