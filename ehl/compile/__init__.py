"""Compilation of kernels: compiler settings, cache on disk, carried kernels, warm-up."""
