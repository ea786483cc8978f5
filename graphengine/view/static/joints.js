// The joints of the selected robot: positions, limits, and sliders that set the targets of their drives.
import { command } from "./connection.js";
import { brief, button, element, put, steady } from "./elements.js";

const WIDEST = { position: Math.PI, velocity: 10 }; // of a slider whose joint has no limit

// Returns a table with a slider for each joint, and `show`, which puts new values into it.
export function jointTable(robot) {
  const table = element("table", "", "joints"), refusal = element("p", "", "refused", { role: "alert" });
  const rows = new Map(robot.joints.map((joint) => [joint.name, jointRow(robot.name, joint, refusal)]));
  table.append(...rows.values());
  const show = (states) => {
    for (const [name, row] of rows) row.show(states[name] ?? []);
  };
  return { parts: robot.joints.length ? [element("h3", "joints"), table, refusal] : [], show };
}

function jointRow(robot, { name, unit, limits, drive }, refusal) {
  const line = element("tr"), about = element("td"), target = element("td"), value = element("output");
  const [low, high] = limits.map((limit, index) => limit ?? (index ? 1 : -1) * (WIDEST[drive] ?? 0));
  const speed = drive === "velocity", targetUnit = speed ? `${unit}/s` : unit;
  about.append(element("div", name), element("div", limits.includes(null) && !speed ? "no limits" :
    `${brief(low, 4)} to ${brief(high, 4)} ${targetUnit}`, "doc"));
  target.append(value, element("span", ` ${unit}`, "unit"));
  line.append(about, target);
  line.show = ([position, , aim, speedAim]) => {
    put(value, steady(position ?? ""));
    if (!slider) return;
    if (!slider.dataset.held) slider.value = (speed ? speedAim : aim) ?? 0;
    put(shownAim, steady(Number(slider.value)));
  };
  const slider = drive && element("input", "", "", { type: "range", min: low, max: high, step: (high - low) / 400, "aria-label": `target of ${name}` });
  const shownAim = element("output"), aimLine = element("div", drive ? "target " : "no drive moves it", "doc");
  if (!drive) {
    target.append(aimLine);
    return line;
  }
  aimLine.append(shownAim, ` ${targetUnit} `);
  if (speed) aimLine.append(button("0", () => { slider.value = 0; send(); }, "small", `stop ${name}`));
  if (document.body.classList.contains("replayed")) slider.disabled = true;
  target.append(slider, aimLine);
  let sending = false, again = false;
  async function send() { // one command at a time: the newest value follows
    again = sending;
    if (sending) return;
    sending = true;
    const { error } = await command("command", { robot, [speed ? "velocities" : "positions"]: { [name]: Number(slider.value) } }, true);
    put(refusal, error ?? "");
    sending = false;
    if (again) send();
  }
  slider.oninput = send;
  slider.onpointerdown = () => { slider.dataset.held = "true"; };
  slider.onpointerup = slider.onpointercancel = () => { delete slider.dataset.held; };
  return line;
}
