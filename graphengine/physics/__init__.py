"""The MuJoCo layer: compiles a scene file to a MuJoCo model and a stage of prims, and gives nodes handles to both.

Each entry of this list imports only from the entries above it:

- `implementations`: the registry of sensors, which are the modules of `sensors`. `kernels`: compiles inner loops with numba.
- `model`: builds the world and its robots, as MuJoCo models and as prims.
- `dynamics`: the laws that act on a model while it runs. `ray_casting`: casts the rays of sensors.
- `core`: steps and resets the model, and keeps the handles. `handles`: joints, poses, conveyors and entities.
- `pictures`: renders camera images. `sensors`: simulates the robots' sensors.
- `simulation`: implements `devices.backend.World` completely.
- `loading`: builds a `loaded_world` from a scene file; robots can be added to that world and removed from it.
- `views`: shows a scene to users. `occupancy`: computes the occupancy map of a scene.
"""
