"""Stored results: HDF5 shards, row format, datasets."""
