"""The 3D part of a page, in the page's process: `scene3d` draws the bodies and the layers; each layer has a module."""
