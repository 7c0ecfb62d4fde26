"""Benchmarks of the toolchain: pictures with known truth, and what endocal makes of them."""
