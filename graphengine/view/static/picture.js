// The bar above the 3D part: which layers it shows, where its camera is, and whether handles move the selection.
import { ask, on } from "./connection.js";
import { $, element, put } from "./elements.js";
import { onSelect, selected } from "./selection.js";

const KEPT = "picture";
let layers = [], choices = { layers: ["robots", "objects", "world", "lidar"], view: "follow", moves: false };
try { choices = { ...choices, ...JSON.parse(sessionStorage.getItem(KEPT)) }; } catch { /* of another version */ }

function tellRun() {
  sessionStorage.setItem(KEPT, JSON.stringify(choices));
  ask({ ask: "picture", ...choices });
}

function choose(change) {
  choices = { ...choices, ...change };
  tellRun();
  show();
}

on("layers", (found) => {
  layers = found;
  $("layer-list").replaceChildren(...layers.map(({ name, title, hint }) => {
    const label = element("label", "", "", { title: hint }), box = element("input", "", "", { type: "checkbox", id: `layer-${name}` });
    box.onchange = () => choose({ layers: box.checked ? [...choices.layers, name] : choices.layers.filter((one) => one !== name) });
    label.append(box, ` ${title}`);
    return label;
  }));
  show();
});
on("open", tellRun);
on("frame", ({ notes }) => put($("layer-notes"), Object.values(notes).join("\n")));
onSelect(show);

function show() {
  for (const { name } of layers) $(`layer-${name}`).checked = choices.layers.includes(name);
  $("view").value = choices.view;
  $("moves").setAttribute("aria-pressed", String(choices.moves));
  put($("picked"), selected.robot || "nothing selected");
}

$("view").onchange = () => choose({ view: $("view").value });
$("moves").onclick = () => choose({ moves: !choices.moves });
document.addEventListener("pointerdown", ({ target }) => { if (!$("layers").contains(target)) $("layers").open = false; });
addEventListener("blur", () => { $("layers").open = false; }); // a click into the 3D part
$("layers").onkeydown = (event) => { if (event.key === "Escape") $("layers").open = false; };
show();
