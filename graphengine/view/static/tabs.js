// The tabs below the 3D part: graph, topics and findings. One is shown.
import { $ } from "./elements.js";

const tabs = [...$("tabs").children];
const listeners = [];
export let shown = "graph";

export function onTab(take) {
  listeners.push(take);
}

export function showTab(name) {
  shown = name;
  for (const tab of tabs) {
    const chosen = tab.id === `${name}-tab`;
    tab.setAttribute("aria-selected", String(chosen));
    tab.tabIndex = chosen ? 0 : -1;
    $(tab.getAttribute("aria-controls")).hidden = !chosen;
  }
  for (const take of listeners) take(name);
}

$("enlarge").onclick = () => {
  const large = document.querySelector("main").classList.toggle("large");
  $("enlarge").setAttribute("aria-pressed", String(large));
};
for (const tab of tabs) tab.onclick = () => showTab(tab.id.replace("-tab", ""));
$("tabs").onkeydown = (event) => {
  const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
  if (!step) return;
  event.preventDefault();
  event.stopPropagation();
  const usable = tabs.filter((tab) => !tab.disabled);
  const next = usable[(usable.indexOf(document.activeElement) + step + usable.length) % usable.length];
  next.focus();
  next.click();
};
