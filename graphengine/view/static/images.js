// The image of a camera, large, in colours or as distances.
import { ask, on } from "./connection.js";
import { $, put } from "./elements.js";
import { onSelect, selected } from "./selection.js";
import { onTab, shown } from "./tabs.js";

let cameras = [];

const tellRun = () => ask({ ask: "image", camera: shown === "images" ? $("camera").value : "", depth: $("depth").checked });

on("stage", ({ robots }) => {
  cameras = robots.flatMap((robot) => robot.sensors.filter((one) => one.kind === "camera").map((one) => ({ ...one, robot: robot.name })));
  const chosen = $("camera").value;
  $("camera").replaceChildren(...cameras.map((one) => new Option(`${one.robot}: ${one.name}`, one.prim)));
  if (cameras.some((one) => one.prim === chosen)) $("camera").value = chosen;
  $("no-image").hidden = cameras.length > 0;
  $("image").hidden = $("camera").disabled = cameras.length === 0;
});
onSelect(() => {
  const now = cameras.find((one) => one.prim === $("camera").value), own = cameras.find((one) => one.robot === selected.robot);
  if (!own || now?.robot === selected.robot) return;
  $("camera").value = own.prim;
  tellRun();
});
onTab(tellRun);
on("open", tellRun);
on("image", ({ camera, source, range, error }) => {
  if (camera !== $("camera").value) return;
  put($("image-range"), error || range);
  if (!source) return;
  $("image").src = source;
  $("image").alt = `image of ${$("camera").selectedOptions[0].text}`;
});
$("camera").onchange = $("depth").onchange = tellRun;
