"""The 3D part of a page, in the page's process: `scene3d` draws what a run tells by layers, one module each."""
