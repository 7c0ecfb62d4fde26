"""Edges measured anew to a fraction of a pixel, on profiles across the lines that a model predicts."""
