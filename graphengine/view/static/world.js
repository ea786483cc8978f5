// Loads the 3D part before the modules of the page, as it takes longest. A separate file, because the page allows no inline scripts.
const world = document.getElementById("world");
const dark = matchMedia("(prefers-color-scheme: dark)").matches ? "darkMode&" : "";
if (socketUrl("3d")) world.src = `3d/?${dark}websocket=${encodeURIComponent(socketUrl("3d"))}`;
world.addEventListener("load", () => {
  const style = world.contentDocument.createElement("style");
  style.textContent = "#webgl-software-rendering, .mantine-Paper-root { display: none !important; }"; // they would cover the world
  world.contentDocument.head.append(style);
});
