"use strict";
// Pan, zoom and ask: the drawing is moved by its viewBox alone, and everything that is told stands in it as a title.
(() => {
  const area = document.getElementById("drawing");
  const drawing = area.querySelector("svg");
  const about = document.getElementById("about");
  const whole = drawing.getAttribute("viewBox").split(" ").map(Number);
  const nodes = [...drawing.querySelectorAll(".node")];
  let view = [...whole];

  const show = (x, y, width, height) => {
    view = [x, y, width, height];
    drawing.setAttribute("viewBox", view.join(" "));
  };

  // How many units of the drawing a pixel of the screen is.
  const unit = () => Math.max(view[2] / area.clientWidth, view[3] / area.clientHeight);

  const inDrawing = (x, y) => new DOMPoint(x, y).matrixTransform(drawing.getScreenCTM().inverse());

  const zoom = (factor, at) => {
    const width = Math.min(Math.max(view[2] / factor, 60), whole[2] * 4);
    const share = width / view[2];
    const point = at || { x: view[0] + view[2] / 2, y: view[1] + view[3] / 2 };
    show(point.x - (point.x - view[0]) * share, point.y - (point.y - view[1]) * share, width, view[3] * share);
  };

  const move = (x, y) => show(view[0] + x * unit(), view[1] + y * unit(), view[2], view[3]);

  const told = (element) => {
    const lines = [];
    for (let part = element; part && part !== drawing; part = part.parentNode) {
      const title = part.querySelector(":scope > title");
      if (title) lines.push(title.textContent);
    }
    return lines.join("\n\n");
  };

  const choose = (node) => {
    nodes.forEach((other) => other.classList.toggle("chosen", other === node));
    about.textContent = [node, ...node.querySelectorAll(".port")].map((part) => part.querySelector("title").textContent).join("\n\n");
    about.scrollTop = 0;
  };

  // A focused node comes into sight.
  const reveal = (node) => {
    const box = node.getBoundingClientRect(), room = area.getBoundingClientRect();
    if (box.left < room.left || box.right > room.right || box.top < room.top || box.bottom > room.bottom) {
      move(box.left + box.width / 2 - room.left - room.width / 2, box.top + box.height / 2 - room.top - room.height / 2);
    }
  };

  nodes.forEach((node) => {
    node.setAttribute("tabindex", "0");
    node.setAttribute("role", "group");
    node.setAttribute("aria-label", node.querySelector("title").textContent);
    node.addEventListener("focus", () => { choose(node); reveal(node); });
  });

  area.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom(Math.exp(-event.deltaY / 400), inDrawing(event.clientX, event.clientY));
  }, { passive: false });

  // Dragging moves the drawing, except from a text, which it selects.
  const fingers = new Map();
  area.addEventListener("pointerdown", (event) => {
    if (event.button === 0 && !event.target.closest("text")) {
      fingers.set(event.pointerId, event);
      area.setPointerCapture(event.pointerId);
    }
  });
  area.addEventListener("pointermove", (event) => {
    const last = fingers.get(event.pointerId);
    if (!last) return;
    if (fingers.size === 1) {
      move(last.clientX - event.clientX, last.clientY - event.clientY);
    } else {
      const other = [...fingers.values()].find((finger) => finger.pointerId !== event.pointerId);
      const distance = (finger) => Math.hypot(finger.clientX - other.clientX, finger.clientY - other.clientY) || 1;
      zoom(distance(event) / distance(last), inDrawing(other.clientX, other.clientY));
    }
    fingers.set(event.pointerId, event);
  });
  ["pointerup", "pointercancel"].forEach((name) => area.addEventListener(name, (event) => fingers.delete(event.pointerId)));

  area.addEventListener("click", (event) => {
    const node = event.target.closest(".node");
    const part = event.target.closest(".port, .connection, .subgraph");
    if (node) choose(node);
    if (part) about.textContent = told(part);
  });

  const keys = {
    "+": () => zoom(1.25), "=": () => zoom(1.25), "-": () => zoom(0.8), "0": () => show(...whole),
    ArrowLeft: () => move(-60, 0), ArrowRight: () => move(60, 0), ArrowUp: () => move(0, -60), ArrowDown: () => move(0, 60),
  };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !Object.hasOwn(keys, event.key)) return;
    if (about.contains(event.target)) return;
    event.preventDefault();
    keys[event.key]();
  });
  document.getElementById("closer").addEventListener("click", keys["+"]);
  document.getElementById("farther").addEventListener("click", keys["-"]);
  document.getElementById("whole").addEventListener("click", keys["0"]);
})();
