"""The MuJoCo layer: compiles scene files to a model and a stage, and gives nodes handles to them.

Each of these imports only from those above it:

- `engine`: MuJoCo with the settings that all of this package uses.
- `files`: reads untrusted files within limits.
- `description`: robot descriptions.
- `model`: the world and its robots as MuJoCo models and as prims.
- `dynamics`: acts on a model while it runs.
- `pictures`: renders camera images.
- `sensors`: the robots' sensors.
- `core`: the model and its state, as handles and sensors use them. `simulation`: the complete `backend.World`.
- `loading` builds a `loaded_world` from a scene file; robots can be added to it. `occupancy` draws the scene's occupancy map.
"""
