"""Acts on a model while it runs: commands, poses, pushes and settings, and the handles by which nodes read and write them."""
