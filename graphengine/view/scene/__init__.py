"""The 3D part of a page, in the page's process. `scene3d` draws bodies and layers; each layer has its own module."""
