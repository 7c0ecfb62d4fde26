"""OpenCL C sources, one job a file, shipped as the package ``endocal.kernels``."""
