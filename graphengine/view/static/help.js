// The keys of the page, which `?` shows.
import { $, element } from "./elements.js";

const KEYS = [
  ["Run", [["space", "pause or continue"], ["Step", "execute ticks of a paused run; the drawing keeps what they executed, in order"]]],
  ["Graph", [["Ctrl F", "find nodes by name, type or port; Enter goes to the next"], ["wheel or + −", "zoom"], ["drag or arrow keys", "move the drawing"],
    ["0", "fit the drawing"], ["Tab, Enter", "go to a node, select it"]]],
  ["Values", [["click a port or field", "plot it, or remove it from the plot"], ["Enter or Tab in an input", "set the value"], ["Esc in an input", "keep the old value"],
    ["drag in a plot", "zoom into times; double-click zooms out"]]],
  ["3D", [["click", "select a robot or object"], ["drag", "turn the camera; right button moves it, wheel zooms"], ["Ctrl drag", "pull a robot or object"]]],
  ["Keyboard on", [["W A S D or arrow keys", "drive the robot"], ["any key", "held for the nodes that read the keyboard"]]],
  ["Recording", [["space", "play or pause"], ["← →", "a tick back or forward; with Shift 1 s"], ["click in a plot", "go to this time"]]],
  ["Everywhere", [["?", "this help"], ["arrow keys in the tree", "move, fold and unfold"]]],
];

$("help-list").replaceChildren(...KEYS.flatMap(([title, keys]) => {
  const list = element("dl");
  for (const [key, meaning] of keys) list.append(element("dt", key), element("dd", meaning));
  return [element("h3", title), list];
}));
$("help").onclick = () => $("help-dialog").showModal();
$("help-close").onclick = () => $("help-dialog").close();
addEventListener("keydown", (event) => {
  if (event.key !== "?" || event.target.closest?.("input, select, textarea") || $("help-dialog").open) return;
  event.preventDefault();
  $("help-dialog").showModal();
});
