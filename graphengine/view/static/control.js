// The header: the time and state of the run, and what holds, steps and resets it.
import { command, on } from "./connection.js";
import { $ } from "./elements.js";

on("stage", ({ title }) => {
  document.title = `${title} - graphrun`;
  $("title").textContent = title;
});

on("frame", ({ facts }) => {
  $("time").textContent = `${facts.time.toFixed(2)} s`;
  $("state").textContent = facts.state;
  $("state").className = `state ${facts.state}`;
  $("rate").textContent = `x${facts.real_time_factor.toFixed(2)}`;
  const { late_ticks: late, message_rate: rate, subscribers, dropped_values: dropped, recorded_bytes: size } = facts;
  const recorded = size === null ? "" : `, ${(size / 1e6).toFixed(1)} MB recorded`;
  $("counts").textContent = `${late} late, ${rate.toFixed(0)} messages/s, ${subscribers} subscribers, ${dropped} dropped${recorded}`;
  const pace = facts.pace === null ? "max" : String(facts.pace);
  if (document.activeElement !== $("pace")) $("pace").value = pace;
});

on("lost", () => {
  $("state").textContent = "disconnected";
  $("state").className = "state failed";
});

$("play").onclick = () => command("play");
$("pause").onclick = () => command("pause");
$("step").onclick = () => command("step");
$("reset").onclick = () => command("reset");
$("pace").onchange = () => command("rate", { factor: $("pace").value === "max" ? "max" : Number($("pace").value) });
