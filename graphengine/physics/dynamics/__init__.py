"""Acts on a running model: joint commands, poses, pushes and settings, and the handles by which nodes read and write them."""
