// Helpers to find, create and fill elements. Strings are inserted as text, never as HTML: names come from files and the network.
export const $ = (id) => document.getElementById(id);

export function element(kind, text = "", className = "", attributes = {}) {
  const made = Object.assign(document.createElement(kind), { textContent: text, className });
  for (const name in attributes) made.setAttribute(name, attributes[name]);
  return made;
}

export function button(text, pressed, className = "") {
  const made = element("button", text, className, { type: "button" });
  made.onclick = pressed;
  return made;
}

// Sets the text of an element only if it changed, so that a selection within it survives.
export function put(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

// Formats a number with the given significant digits; returns other values unchanged.
export function brief(value, digits = 6) {
  return typeof value === "number" ? String(+value.toPrecision(digits)) : (value ?? "");
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

// Creates a position in a file with a button that copies it as `path:line` for editors.
export function place(shown, copied) {
  const line = note(shown);
  const copy = button("copy", () => copyText(copied, copy), "small");
  copy.title = `copy ${copied}`;
  copy.setAttribute("aria-label", `copy the place ${shown}`);
  line.append(" ", copy);
  return line;
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
  source.textContent = "copied";
  setTimeout(() => { source.textContent = "copy"; }, 1500);
}
