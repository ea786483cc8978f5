// What is selected: a graph, a node of it, a robot. Modules that show it listen.
export const selected = { graph: "", node: "", robot: "" };
const listeners = [];

export function onSelect(take) {
  listeners.push(take);
}

// Selects something else; `what` tells which of the three the user meant.
export function select(what, names) {
  Object.assign(selected, names);
  for (const take of listeners) take(what);
}
