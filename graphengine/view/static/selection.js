// The selected graph, node and robot; modules that show the selection listen for changes.
export const selected = { graph: "", node: "", robot: "" };
const listeners = [];

export function onSelect(take) {
  listeners.push(take);
}

// Changes the selection; `what` is the kind of item that the user selected.
export function select(what, names) {
  Object.assign(selected, names);
  for (const take of listeners) take(what);
}
