// The WebSocket to the run: passes messages to listeners by kind, and sends requests of the viewer.
const listeners = {};
const answers = new Map();
let socket, asked = 0, ended = false;

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
    if (ended) return;
    tell("lost");
    setTimeout(connect, 1000);
  };
}

export function ask(what) {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(what));
}

// Sends a command to the run; the response has a result or an error, which is also shown as a message.
export function command(name, args = {}) {
  return new Promise((resolve) => {
    const id = ++asked;
    answers.set(id, resolve);
    ask({ ask: "command", id, command: name, arguments: args });
  });
}

on("answer", (answer) => {
  tell("notice", answer.error ?? "");
  answers.get(answer.id)?.(answer);
  answers.delete(answer.id);
});
on("ended", () => { ended = true; });
