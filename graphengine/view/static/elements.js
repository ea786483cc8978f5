// Short forms to find and make elements.
export const $ = (id) => document.getElementById(id);

export function element(kind, text = "", className = "") {
  return Object.assign(document.createElement(kind), { textContent: text, className });
}
