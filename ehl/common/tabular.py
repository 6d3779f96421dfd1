"""Results with one row per point or case, for programs that read xarray or Parquet (extra `tables`)."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from ehl.common.errors import InputError
from ehl.common.files import replacing
from ehl.common.quantities import quantities, si_unit

if TYPE_CHECKING:
    import pandas as pd
    import xarray


def _units(frame: pd.DataFrame) -> dict[str, str]:
    """SI unit of each column that has one."""
    return {name: unit for name in map(str, frame.columns) if name in quantities() and (unit := si_unit(name))}


def _required(error: ImportError) -> InputError:
    hint = "Install it with: pip install 'mixed-ehl[tables]'. CSV and XLSX require no extra."
    return InputError("package", error.name, "an installed package", hint)


class Tabular:
    """A result with `to_frame`."""

    def to_frame(self) -> pd.DataFrame:
        """One row per point, SI units."""
        raise NotImplementedError

    def _dimensions(self) -> tuple[str, ...]:
        """Columns that are the axes; without any, the rows are one dimension, `case`."""
        return ()

    def to_xarray(self) -> xarray.Dataset:
        """The result over its axes, with SI units as the attribute `units` of each variable.

        Raises
        ------
        InputError
            The package xarray is not installed.
        """
        try:
            import xarray
        except ImportError as error:
            raise _required(error) from None
        frame, axes = self.to_frame(), list(self._dimensions())
        found: xarray.Dataset = xarray.Dataset.from_dataframe(
            frame.set_index(axes) if axes else frame.rename_axis("case")
        )
        for name, unit in _units(frame).items():
            found[name].attrs["units"] = unit
        return found

    def to_parquet(self, path: str | PathLike[str]) -> None:
        """Write the rows as a Parquet file, with the SI unit in the metadata of each column.

        Raises
        ------
        InputError
            The package pyarrow is not installed, or the file cannot be written.
        """
        try:
            import pyarrow
            from pyarrow import parquet
        except ImportError as error:
            raise _required(error) from None
        frame = self.to_frame()
        table, units = pyarrow.Table.from_pandas(frame, preserve_index=False), _units(frame)
        fields = [field.with_metadata({"unit": units.get(field.name, "")}) for field in table.schema]
        with replacing(Path(path), "parquet") as draft:
            parquet.write_table(table.cast(pyarrow.schema(fields, metadata=table.schema.metadata)), draft)
