// Controls of a recording: slider, replayed part, events and playback.
import { ask, on } from "./connection.js";
import { $, element } from "./elements.js";
import { link } from "./selection.js";

const SIGNS = { command: "◆", reset: "↺", contact: "●", verdict: "⚑", error: "✕" }; // of several events at one position, the last is shown
const PLACES = 80, LINES = 10;
const REASONS = { "topics-tab": "topics are measured in a run only; the messages are in the recording's MCAP file",
  "findings-tab": "the files of a recording are not checked" };
let shown = null, marks = [], asking = null;

const play = (what) => ask({ ask: "playback", ...what });
const seconds = (ticks) => (ticks * shown.seconds).toFixed(2);
const percent = (tick) => `${(100 * tick) / Math.max(shown.length, 1)}%`;

on("frame", ({ facts: { recording } }) => {
  if (!recording) return;
  const resized = shown?.length !== recording.length;
  const first = !shown;
  if (first) begin();
  shown = recording;
  if (first && linked.has("t")) seek(Math.round(Number(linked.get("t")) / shown.seconds) || 0);
  else if (asking === null && shown.complete) link({ t: seconds(shown.position) });
  $("playback").textContent = shown.playing ? "Pause" : "Play";
  $("place").textContent = `${seconds(shown.position)} / ${seconds(shown.length)} s`;
  $("slider").max = shown.length;
  if (asking === null) $("slider").value = shown.position;
  $("slider").setAttribute("aria-valuetext", `${seconds(shown.position)} s`);
  $("built").style.width = percent(shown.built);
  $("built").title = `replayed up to ${seconds(shown.built)} s`;
  if (document.activeElement !== $("speed")) $("speed").value = String(shown.speed);
  $("verdict").textContent = shown.verdict;
  $("verdict").classList.toggle("different", shown.different);
  if (resized) placeMarks();
});

// Shows the controls of a recording, and why those of a run are not available.
function begin() {
  document.body.classList.add("replayed");
  $("recording").hidden = false;
  for (const id in REASONS) Object.assign($(id), { disabled: true, title: REASONS[id] });
}

on("marks", ({ all }) => {
  marks = all;
  if (shown) placeMarks();
});

function placeMarks() {
  $("marks").replaceChildren(...groups().map((group) => {
    const kind = Object.keys(SIGNS).findLast((one) => group.some((mark) => mark.kind === one));
    const button = element("button", SIGNS[kind], kind);
    const lines = group.map((mark) => `${seconds(mark.tick)} s: ${mark.text}`);
    button.title = [...lines.slice(0, LINES), ...(lines.length > LINES ? [`and ${lines.length - LINES} more`] : [])].join("\n");
    button.setAttribute("aria-label", button.title);
    button.style.left = percent(group[0].tick);
    button.onclick = () => seek(group[0].tick);
    return button;
  }));
}

// Marks that would overlap share a button.
function groups() {
  const found = [];
  for (const mark of marks) {
    if (found.length && mark.tick - found.at(-1)[0].tick < shown.length / PLACES) found.at(-1).push(mark);
    else found.push([mark]);
  }
  return found;
}

// While the slider moves, requests at most one position per browser frame: the last.
export function seek(tick) {
  if (asking === null) {
    requestAnimationFrame(() => {
      play({ do: "seek", tick: asking });
      asking = null;
    });
  }
  asking = Math.min(Math.max(tick, 0), shown.length);
}

const toggle = () => play({ do: shown.playing ? "pause" : "play" });
const step = (ticks) => play({ do: "step", ticks });

$("playback").onclick = toggle;
$("back").onclick = () => step(-1);
$("forward").onclick = () => step(1);
$("slider").oninput = () => seek(Number($("slider").value));
$("speed").onchange = () => play({ do: "speed", factor: Number($("speed").value) });

addEventListener("keydown", (event) => {
  if (!shown || event.defaultPrevented || event.ctrlKey || event.altKey || event.metaKey) return;
  if (event.target.matches("select, input:not([type=range]), [role=tab]")) return;
  const far = event.shiftKey ? Math.round(1 / shown.seconds) : 1;
  if (event.code === "Space" && !event.target.matches("button, [role=treeitem], [role=button]")) toggle();
  else if (event.code === "ArrowLeft") step(-far);
  else if (event.code === "ArrowRight") step(far);
  else return;
  event.preventDefault();
});
