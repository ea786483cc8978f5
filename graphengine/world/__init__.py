"""The MuJoCo seam: scene files to a model and a stage, and the handles that nodes hold."""
