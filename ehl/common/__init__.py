"""Common ground of the three packages: errors, units, validation, files, tables, notes, pages, progress."""
