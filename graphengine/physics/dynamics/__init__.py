"""What acts on a model while it runs: commands, poses, pushes and changes, and the handles by which nodes read and write them."""
