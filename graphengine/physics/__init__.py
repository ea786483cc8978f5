"""The MuJoCo seam: scene files to a model and a stage, and the handles that nodes hold.

Each of these imports from those above it only:

- `engine` is MuJoCo as all of it is used here.
- `files`: what strangers wrote, read within bounds.
- `description`: what a robot consists of.
- `model`: the world and its robots, for MuJoCo to compile and as prims.
- `dynamics`: what acts on a model while it runs.
- `pictures`: what cameras see of it.
- `sensors`: what robots sense with.
- `core`: the model and its state, which handles and sensors see too. `simulation`: all of that as a `backend.World`.
- `loading` makes a `loaded_world` of a scene file, to which robots are added, and `occupancy` draws its map.
"""
