"""Video in and out over PyAV, losing nothing on the way."""
