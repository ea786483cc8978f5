// Short forms to find, make and fill elements. Texts go in as text: names come from files and from the network.
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

// Sets a text only if it is another one, so that a selection within it survives.
export function put(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

// A number with so many digits that count; anything else as it is.
export function brief(value, digits = 6) {
  return typeof value === "number" ? String(+value.toPrecision(digits)) : (value ?? "");
}

// A paragraph about something, whose long name may break after a dot or a slash.
export function note(text) {
  const line = element("p", "", "place");
  for (const part of text.split(/(?<=[./])/)) line.append(part, element("wbr"));
  return line;
}

// Shows one of the details at the right.
export function showDetail(id) {
  for (const one of $("side").children) one.hidden = one.id !== id;
}

// A place in a file with a button that copies it as `path:line`, which editors take.
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
  } catch { // not on a page that is served to other machines, unencrypted
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
