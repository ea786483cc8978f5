// A recording: its slider, what of it was replayed, its events, and the clock that plays it.
import { ask, on } from "./connection.js";
import { $, element } from "./elements.js";

const SIGNS = { command: "◆", reset: "↺", error: "✕", contact: "●" };
let shown = null, marks = [], asking = null;

const play = (what) => ask({ ask: "playback", ...what });
const seconds = (ticks) => (ticks * shown.seconds).toFixed(2);
const percent = (tick) => `${(100 * tick) / Math.max(shown.length, 1)}%`;

on("frame", ({ facts: { recording } }) => {
  if (!recording) return;
  const resized = shown?.length !== recording.length;
  shown = recording;
  document.body.classList.add("replayed");
  $("recording").hidden = false;
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

on("marks", ({ all }) => {
  marks = all;
  if (shown) placeMarks();
});

function placeMarks() {
  $("marks").replaceChildren(...marks.map((mark) => {
    const text = `${seconds(mark.tick)} s: ${mark.text}`;
    const button = element("button", SIGNS[mark.kind], mark.kind);
    button.title = text;
    button.setAttribute("aria-label", `${mark.kind}, ${text}`);
    button.style.left = percent(mark.tick);
    button.onclick = () => seek(mark.tick);
    return button;
  }));
}

// Of the places that a moving slider passes, the last of each picture of the browser is asked for.
function seek(tick) {
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
  if (!shown || event.ctrlKey || event.altKey || event.metaKey) return;
  if (event.target.matches("select, input:not([type=range])")) return;
  const far = event.shiftKey ? Math.round(1 / shown.seconds) : 1;
  if (event.code === "Space" && !event.target.matches("button")) toggle();
  else if (event.code === "ArrowLeft") step(-far);
  else if (event.code === "ArrowRight") step(far);
  else return;
  event.preventDefault();
});
