// Loads the 3D part before the modules of the page, as it takes longest. A separate file, because the page allows no inline scripts.
document.getElementById("world").src = matchMedia("(prefers-color-scheme: dark)").matches ? "3d/?darkMode" : "3d/";
