"""Stored results: HDF5 shards, row format, datasets."""

from __future__ import annotations
