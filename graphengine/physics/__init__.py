"""The MuJoCo layer: compiles a scene file to a MuJoCo model and a stage of prims, and gives nodes handles to both.

Each entry of this list imports only from the entries above it:

- `engine`: imports MuJoCo with the settings that the whole package uses.
- `files`: reads untrusted files within limits.
- `description`: reads robot descriptions.
- `model`: builds the world and its robots, as MuJoCo models and as prims.
- `dynamics`: acts on a model while it runs.
- `pictures`: renders camera images.
- `sensors`: simulates the robots' sensors.
- `core`: steps and resets the model; handles and sensors use it. `simulation`: implements `devices.backend.World` completely.
- `loading`: builds a `loaded_world` from a scene file; robots can be added to that world and removed from it.
  `occupancy`: computes the occupancy map of a scene.
"""
