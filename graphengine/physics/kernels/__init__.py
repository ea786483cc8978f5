"""Machine code for inner loops: kernels that numba compiles, if it works."""
