"""Casts the rays of sensors, by MuJoCo or by kernels that numba compiles."""
