// The WebSocket to the run: passes messages to listeners by kind, and sends requests of the viewer.
const listeners = {};
const answers = new Map();
let socket, asked = 0, run = "";

export function on(kind, take) {
  (listeners[kind] ??= []).push(take);
}

export function tell(kind, content) {
  for (const take of listeners[kind] ?? []) take(content);
}

export function connect() {
  if (!socketUrl("feed")) return tell("locked");
  socket = new WebSocket(socketUrl("feed"));
  socket.onmessage = (event) => {
    const told = JSON.parse(event.data);
    for (const kind in told) tell(kind, told[kind]);
  };
  socket.onopen = () => tell("open");
  socket.onclose = () => {
    tell("lost");
    setTimeout(connect, 1000); // until the run, or the next one on this port, answers
  };
}

export function ask(what) {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(what));
}

// Sends a command to the run; the response has a result or an error, which is also shown as a message unless `quiet`.
export function command(name, args = {}, quiet = false) {
  return new Promise((resolve) => {
    const id = ++asked;
    answers.set(id, { resolve, quiet });
    ask({ ask: "command", id, command: name, arguments: args });
  });
}

on("answer", (answer) => {
  const waiting = answers.get(answer.id);
  if (!waiting?.quiet) tell("notice", answer.error ?? "");
  waiting?.resolve(answer);
  answers.delete(answer.id);
});
// A new run on the same port: the page begins anew, with the selection in its address.
on("run", (name) => {
  if (run && run !== name) location.reload();
  run = name;
});
