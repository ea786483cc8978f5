// Writes an edited input into the file that sets it, and takes this back.
import { command } from "./connection.js";
import { button, element, put } from "./elements.js";

let latest = "", undone = false; // the last change that this page has written; it survives the reload that follows

export function savePart(address) {
  const part = element("span", "", "save"), change = element("span", "", "change", { role: "status" });
  const write = button("Write", () => act("save", { address }, change));
  write.hidden = true;
  const pencil = button("✎", async () => {
    const { result, error } = await command("save", { address, preview: true }, true);
    put(change, error ?? result.text);
    write.hidden = Boolean(error);
  }, "plain", "show what saving this value changes in its file");
  part.append(pencil, change, write);
  return part;
}

// The last change, with a button that takes it back or writes it again; empty before the first one.
export function changePart() {
  const part = element("div", "", "save"), change = element("span", latest, "change", { role: "status" });
  if (latest) part.append(change, undone ? button("Redo", () => act("redo", {}, change)) : button("Undo", () => act("undo", {}, change)));
  return part;
}

async function act(name, args, change) {
  const before = [latest, undone];
  undone = name === "undo"; // the reload may show the pane anew before the answer arrives
  const { result, error } = await command(name, args, true);
  if (error) [latest, undone] = before;
  else latest = result.text;
  put(change, error ?? result.text);
  for (const place of error ? [] : document.querySelectorAll("#node-side div.save")) place.replaceWith(changePart());
}
