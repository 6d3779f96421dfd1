"""Unloaded contact: ease-off, contact lines, transmission error."""
