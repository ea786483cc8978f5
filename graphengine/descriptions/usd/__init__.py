"""Reads robots from USD stages: UsdPhysics, and what Isaac Sim's schemas add to it.

- `stage_files` asks for a stage and reports what USD cannot read; `prim_spans` finds prims in the text of a file.
- `stage_physics_process` is the confined process that opens a stage, as a `confined_reading`: `layers` opens its files,
  `stage_frames` converts units and axes; `stage_bodies`, `stage_shapes`, `stage_joints`, `stage_materials`, `stage_commands`,
  `stage_lights` and `stage_sensors` read one subject each.
- `usd_model`, below this package, is the plain data that the process returns, in SI units with z up.
- `articulations` finds the robots among the bodies and joints; `usd_links` and `usd_masses` make links of them, and `usd_reader`
  the description.
"""
