// The topics of the run with their rates, and the newest message of the selected topic.
import { ask, on } from "./connection.js";
import { bytes } from "./control.js";
import { $, element, put, putValue, showDetail, valueCell } from "./elements.js";
import { plot } from "./plots.js";
import { onTab, shown, showTab } from "./tabs.js";

const rows = new Map(); // by topic
const folded = new Set(); // paths of fields
let looked = "", newest = [];

function tellRun() {
  ask({ ask: "topics", open: shown === "topics", topic: looked });
}

onTab((name) => {
  tellRun();
  if (name === "topics") showDetail("message-side");
});
on("open", tellRun);

// Shows the topics of a namespace.
export function showTopicsOf(namespace) {
  $("topic-filter").value = namespace ? `/${namespace}/` : "";
  showTab("topics");
  filter();
}

on("topics", (topics) => {
  newest = topics;
  if (shown !== "topics") return;
  const names = topics.map((one) => one.name);
  for (const [name, row] of rows) if (!names.includes(name)) { row.remove(); rows.delete(name); }
  for (const topic of topics) {
    const row = rows.get(topic.name) ?? makeRow(topic.name);
    const texts = [topic.type.replace("/msg/", "/"), topic.rate === null ? "" : `${topic.rate.toFixed(1)} Hz`,
      topic.bandwidth === null ? "" : `${bytes(topic.bandwidth)}/s`, String(topic.subscribers),
      topic.publishers ? (topic.wanted ? "sent" : "not wanted") : "received"];
    texts.forEach((text, index) => put(row.children[index + 1], text));
    row.title = topic.nodes.join("\n");
    row.classList.toggle("unwanted", !topic.wanted);
  }
  filter();
});

function makeRow(name) {
  const row = element("tr"), cell = element("td"), choose = element("button", name, "plain", { type: "button" });
  cell.append(choose);
  row.append(cell, ...["", "number", "number", "number", ""].map((kind) => element("td", "", kind)));
  row.onclick = () => look(name);
  const next = [...rows.keys()].find((other) => other > name);
  $("topics").insertBefore(row, next ? rows.get(next) : null);
  rows.set(name, row);
  return row;
}

function look(name) {
  looked = name;
  for (const [topic, row] of rows) row.classList.toggle("selected", topic === name);
  $("message-head").replaceChildren(element("h2", name), element("p", "waiting for a message", "place", { id: "message-type" }));
  $("message-rows").replaceChildren();
  showDetail("message-side");
  tellRun();
}

function filter() {
  const words = $("topic-filter").value.toLowerCase().split(/\s+/).filter(Boolean);
  for (const [name, row] of rows) {
    const found = `${name} ${row.children[1].textContent}`.toLowerCase();
    row.hidden = !words.every((word) => found.includes(word));
  }
}
$("topic-filter").oninput = filter;

// The newest message: one row per field; rows are reused while values change.
on("message", (message) => {
  if (message.topic !== looked) return;
  const waiting = message.size ? (message.rows.length ? "" : ", too large to show") : ", waiting for a message";
  put($("message-type"), `${message.type}${message.size ? `, ${bytes(message.size)}` : ""}${waiting}`);
  const lines = $("message-rows").children;
  message.rows.forEach((row, index) => {
    if (lines[index]?.dataset.path === row.path && row.text) putValue(lines[index].children[1], row.text);
    else if (lines[index]?.dataset.path === row.path) return;
    else if (lines[index]) lines[index].replaceWith(fieldRow(row));
    else $("message-rows").append(fieldRow(row));
  });
  while (lines.length > message.rows.length) lines[lines.length - 1].remove();
  fold();
});

function fieldRow(row) {
  const line = element("tr", "", "", { "data-path": row.path, title: `${row.path}: ${row.type}` });
  const name = element("td", "", "field");
  name.style.paddingLeft = `${row.depth * 14}px`;
  if (row.text === "" && row.type) {
    const button = element("button", row.name, "plain fold", { type: "button", "aria-expanded": "true" });
    button.onclick = () => {
      if (!folded.delete(row.path)) folded.add(row.path);
      fold();
    };
    name.append(button);
  } else if (row.plots) {
    const choose = element("button", row.name, "plain", { type: "button", title: `plot ${row.path}` });
    choose.onclick = () => plot(`message("${looked}").${row.path}`, `${looked}.${row.path}`);
    name.append(choose);
  } else name.textContent = row.name;
  line.append(name, row.text ? valueCell(row.text) : element("td", "", "value"));
  return line;
}

function fold() {
  for (const line of $("message-rows").children) {
    const path = line.dataset.path;
    line.hidden = [...folded].some((other) => path.startsWith(`${other}.`) || path.startsWith(`${other}[`));
    line.querySelector("button")?.setAttribute("aria-expanded", String(!folded.has(path)));
  }
}
