// The header and the status line: time and state of the run, and its controls.
import { command, on } from "./connection.js";
import { $, element, put } from "./elements.js";

const LATE = 1500; // ms without a frame after which a playing run is shown as waiting
let playing = false, latest = 0;

on("stage", ({ title }) => {
  document.title = `${title} - graphrun`;
  put($("title"), title);
});

on("frame", ({ facts }) => {
  latest = performance.now();
  put($("time"), `${facts.time.toFixed(2)} s`);
  showState(facts.state);
  put($("rate"), `×${facts.real_time_factor.toFixed(2)}`);
  playing = facts.state === "playing";
  $("play").hidden = playing;
  $("pause").hidden = !playing;
  $("step").disabled = playing;
  const pace = facts.pace === null ? "max" : String(facts.pace);
  if (document.activeElement !== $("pace")) showPace(pace);
  if (document.activeElement !== $("seed") && !$("seed").dataset.changed) $("seed").value = facts.seed;
  showFailure(facts.failure);
  showFacts(facts);
});

function showState(state, why = "") {
  put($("state"), state);
  $("state").className = `state ${state}`;
  $("state").title = why;
}

setInterval(() => {
  if ($("state").textContent === "playing" && performance.now() - latest > LATE)
    showState("waiting", "no ticks: the program that runs the session is not stepping it");
}, 500);

function showPace(pace) {
  if (![...$("pace").options].some((one) => one.value === pace)) $("pace").append(new Option(pace, pace));
  $("pace").value = pace;
}

function showFailure(text) {
  $("failure").hidden = !text;
  put($("failure"), text);
}

// The counters of the run; the size of the recording is shown only if there is one.
function showFacts(facts) {
  const shown = {
    tick: facts.tick, "late ticks": facts.late_ticks, "messages/s": facts.message_rate.toFixed(0),
    subscribers: facts.subscribers, "dropped values": facts.dropped_values,
    recorded: facts.recorded_bytes === null ? null : bytes(facts.recorded_bytes),
  };
  for (const name in shown) {
    const id = `fact-${name.replace(/\W/g, "-")}`;
    if (shown[name] === null) continue;
    if (!$(id)) {
      const fact = element("span", "", "fact");
      fact.append(`${name} `, element("b", "", "", { id }));
      $("facts").append(fact);
    }
    put($(id), String(shown[name]));
    $(id).classList.toggle("alert", name in { "late ticks": 0, "dropped values": 0 } && shown[name] > 0);
  }
}

export function bytes(count) {
  const [unit, size] = count < 1e3 ? ["B", 1] : count < 1e6 ? ["kB", 1e3] : count < 1e9 ? ["MB", 1e6] : ["GB", 1e9];
  return `${size === 1 ? Math.round(count) : (count / size).toPrecision(3)} ${unit}`;
}

let over = false; // whether the run has told its end
on("lost", () => {
  if (!over) showState("disconnected", "waiting for the run; one that is started again on this --view-port shows itself here");
});
on("open", () => { if (over) location.reload(); });
on("locked", () => {
  showState("disconnected");
  showFailure("Open the address that graphrun printed: it contains the token of this run.");
});
on("ended", ({ error }) => {
  over = true;
  showState(error ? "failed" : "ended");
  showFailure(error);
  for (const control of document.querySelectorAll("header button, header input, header select")) control.disabled = true;
});
on("notice", (text) => {
  $("message").hidden = !text;
  put($("message-text"), text);
});
$("message-close").onclick = () => { $("message").hidden = true; };

$("play").onclick = () => command("play");
$("pause").onclick = () => command("pause");
$("step").onclick = () => command("step", { ticks: Number($("ticks").value) });
$("seed").oninput = () => { $("seed").dataset.changed = "true"; };
$("reset").onclick = () => {
  command("reset", $("seed").dataset.changed ? { seed: Number($("seed").value) } : {});
  delete $("seed").dataset.changed;
};
$("pace").onchange = () => command("rate", { factor: $("pace").value === "max" ? "max" : Number($("pace").value) });
addEventListener("keydown", (event) => {
  if (document.body.classList.contains("replayed")) return; // recording.js plays
  if (event.code !== "Space" || event.target.closest?.("input, select, button, textarea, [role=treeitem], [role=button]")) return;
  event.preventDefault();
  command(playing ? "pause" : "play");
});
