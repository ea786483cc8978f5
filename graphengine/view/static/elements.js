// Helpers to find, create and fill elements. Strings are inserted as text, never as HTML: names come from files and the network.
const TINY = 1e-12; // numbers below are rounding errors
export const $ = (id) => document.getElementById(id);

export function element(kind, text = "", className = "", attributes = {}) {
  const made = Object.assign(document.createElement(kind), { textContent: text, className });
  for (const name in attributes) made.setAttribute(name, attributes[name]);
  return made;
}

// Creates a button; the name explains a text that is only a sign.
export function button(text, pressed, className = "", name = "") {
  const made = element("button", text, className, { type: "button", ...(name && { title: name, "aria-label": name }) });
  made.onclick = pressed;
  return made;
}

// Sets the text of an element only if it changed, so that a selection within it survives.
export function put(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

// Formats a number with the given significant digits; returns other values unchanged.
export function brief(value, digits = 6) {
  if (typeof value !== "number") return value ?? "";
  return Math.abs(value) < TINY ? "0" : String(+value.toPrecision(digits));
}

// Formats a number with five digits, also trailing zeros, so that a changing number keeps its width.
export function steady(value) {
  if (typeof value !== "number") return String(value ?? "");
  if (Number.isInteger(value) || Math.abs(value) < TINY) return String(Math.round(value));
  const size = Math.floor(Math.log10(Math.abs(value)));
  return size < -4 || size > 8 ? value.toExponential(3) : value.toFixed(Math.max(4 - Math.max(size, 0), 0));
}

export const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

export function download(name, blob) {
  const link = element("a", "", "", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

// Creates a paragraph in which long names may break after a dot or a slash.
export function note(text) {
  const line = element("p", "", "place");
  for (const part of text.split(/(?<=[./])/)) line.append(part, element("wbr"));
  return line;
}

// Shows one of the detail panels on the right.
export function showDetail(id) {
  for (const one of $("side").children) one.hidden = one.id !== id;
}

// Creates a cell for a value; a click copies the value.
export function valueCell(text = "", attributes = {}) {
  const cell = element("td", "", "value", attributes), made = button(text, () => copyText(made.dataset.exact ?? made.textContent, made), "plain copies");
  made.title = "copy this value";
  cell.append(made);
  return cell;
}

// Shows a text in such a cell; the copy is exact.
export function putValue(cell, text, exact = text) {
  if (cell.firstChild.textContent === "copied") return;
  put(cell.firstChild, text);
  cell.firstChild.dataset.exact = exact;
}

// Creates a position in a file with a button that copies it as `path:line` for editors.
export function place(shown, copied) {
  const line = note(shown);
  line.append(" ", copyButton(() => copied, `copy ${copied}`));
  return line;
}

// Creates a button that copies the text that a function returns.
export function copyButton(text, name, sign = "copy") {
  const made = button(sign, () => copyText(text(), made), "small", name);
  return made;
}

async function copyText(text, source) {
  try {
    await navigator.clipboard.writeText(text);
  } catch { // the clipboard is not available on a page that other machines load without encryption
    const field = Object.assign(element("textarea"), { value: text });
    document.body.append(field);
    field.select();
    document.execCommand("copy");
    field.remove();
    source.focus();
  }
  const sign = source.textContent;
  source.textContent = "copied";
  setTimeout(() => { source.textContent = sign; }, 1500);
}
