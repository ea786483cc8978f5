// Loads the 3D part before the modules of the page, as it takes longest. A separate file, because the page allows no inline scripts.
const world = document.getElementById("world");
world.src = matchMedia("(prefers-color-scheme: dark)").matches ? "3d?darkMode" : "3d";
world.addEventListener("load", () => {
  const style = world.contentDocument.createElement("style");
  style.textContent = "#webgl-software-rendering { display: none !important; }"; // this notice would cover the world
  world.contentDocument.head.append(style);
});
