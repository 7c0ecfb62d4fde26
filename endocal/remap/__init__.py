"""Resampling a frame through a model: output geometry and the two engines, NumPy and OpenCL."""
