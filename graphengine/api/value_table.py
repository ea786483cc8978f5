"""Tables of values over time: one column of times, and one column for each number or text; written as CSV or Parquet."""

from __future__ import annotations

import csv
import io
import json
import os
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from graphengine.format.atomic_write import write_together
from graphengine.format.distribution import install_command
from graphengine.format.errors import UsageError
from graphengine.messages.message_text import TypedValue

MAX_COLUMNS = 10_000
"""Maximum number of columns."""
MAX_ELEMENTS = 5000
"""Maximum number of elements of an array; the columns of longer arrays, such as images, are left out."""
ROWS_AT_ONCE = 10_000
"""Number of rows that are converted to Parquet together."""


class ValueTable:
    """Rows, of which several can have the same time, in a temporary file until all columns are known. Close it after use."""

    def __init__(self) -> None:
        self.columns: dict[str, type] = {}
        """Type of each column's values: bool, int, float or str."""
        self.omitted: dict[str, int] = {}
        """Number of elements of each array that is left out because it is too long."""
        self._rows = tempfile.TemporaryFile("w+", encoding="utf-8")  # noqa: SIM115  # `close` closes it
        self._time = 0
        self._row: dict[str, Any] = {}
        self._held: dict[str, Any] = {}
        self._messages: set[str] = set()
        """Topics of the messages in the present row."""

    def begin_message(self, time: int, topic: str) -> None:
        """Begin a new row if the present row already has a message of this topic: several messages can have the same time."""
        if time == self._time and topic in self._messages:
            self._end_row()
        self._begin_time(time)
        self._messages.add(topic)

    def _begin_time(self, time: int) -> None:
        if time != self._time:
            self._end_row()
            self._time = time

    def add(self, time: int, name: str, value: Any, *, held: bool = False) -> None:
        """Add a value at a time, ns; times must not decrease.

        Args:
            time: time, ns.
            name: name of the column; an array gets the columns `name[0]`, `name[1]`, …
            value: number, text, array or message.
            held: whether the value also stands in later rows, until the next one of its column.

        Raises:
            UsageError: the table has too many columns.
        """
        self._begin_time(time)
        for column, cell in self._cells(name, value):
            self._row[column] = cell
            if held:
                self._held[column] = cell
            kind, before = type(cell), self.columns.get(column)
            if before is None and len(self.columns) >= MAX_COLUMNS:
                raise UsageError(f"the table has more than {MAX_COLUMNS} columns; choose fewer topics, fields or ports")
            if before is not kind and cell is not None:
                numbers = {before, kind} == {int, float}
                self.columns[column] = kind if before is None else float if numbers else str

    def _cells(self, name: str, value: Any) -> Iterator[tuple[str, Any]]:
        if isinstance(value, TypedValue):
            if value.is_message:
                for field, part in value.fields():
                    yield from self._cells(f"{name}.{field}", part)
                return
            if value.is_array and not value.scalar and len(value.value) <= MAX_ELEMENTS:
                for index, element in enumerate(value.elements()):
                    yield from self._cells(f"{name}[{index}]", element)
                return
            value = value.value
        if isinstance(value, np.ndarray | tuple | list):
            flat = value.ravel().tolist() if isinstance(value, np.ndarray) else value
            if len(flat) > MAX_ELEMENTS:
                self.omitted[name] = len(flat)
                return
            for index, element in enumerate(flat):
                yield from self._cells(f"{name}[{index}]", element)
            return
        value = value.item() if isinstance(value, np.generic) else value
        yield name, value if isinstance(value, bool | int | float | str) else str(value)

    def _end_row(self) -> None:
        if self._row:
            json.dump([self._time, {**self._held, **self._row}], self._rows)
            self._rows.write("\n")
            self._row = {}
        self._messages.clear()

    def rows(self) -> Iterator[tuple[float, Mapping[str, Any]]]:
        """Yield the time (s) and the values of each row by name of the column."""
        self._end_row()
        self._rows.seek(0)
        for line in self._rows:
            time, row = json.loads(line)
            yield time / 1e9, row
        self._rows.seek(0, os.SEEK_END)

    def csv(self) -> Iterator[str]:
        """Yield the lines of a CSV file; a cell without value is empty."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        for row in self._csv_rows():
            writer.writerow(row)
            yield text.getvalue()
            text.seek(0)
            text.truncate()

    def _csv_rows(self) -> Iterator[list[Any]]:
        self._end_row()
        yield ["time", *self.columns]
        for time, row in self.rows():
            yield [time, *(_csv_cell(row.get(column)) for column in self.columns)]

    def write(self, path: Path) -> None:
        """Write the table to a file, as Parquet if its name ends in `.parquet`, else as CSV.

        Raises:
            OSError: the file cannot be written.
            UsageError: Parquet needs the package pyarrow, which is not installed.
        """
        with tempfile.TemporaryDirectory() as folder:
            made = Path(folder, "table")
            if path.suffix == ".parquet":
                self._write_parquet(made)
            else:
                with made.open("w", encoding="utf-8") as file:
                    file.writelines(self.csv())
            write_together({path: made.read_bytes()})

    def _write_parquet(self, path: Path) -> None:
        try:
            import pyarrow as arrow
            from pyarrow import parquet
        except ImportError:
            raise UsageError(f"Parquet needs the package pyarrow: {install_command('parquet')}") from None
        self._end_row()
        kinds = {bool: arrow.bool_(), int: arrow.int64(), float: arrow.float64(), str: arrow.string()}
        fields = [("time", arrow.float64()), *((name, kinds[kind]) for name, kind in self.columns.items())]
        schema, rows = arrow.schema(fields), list[dict[str, Any]]()
        with parquet.ParquetWriter(path, schema) as writer:
            for time, row in self.rows():
                cells = {name: kind(row[name]) for name, kind in self.columns.items() if name in row}
                rows.append({"time": time, **cells})
                if len(rows) == ROWS_AT_ONCE:
                    writer.write_table(arrow.Table.from_pylist(rows, schema))
                    rows.clear()
            writer.write_table(arrow.Table.from_pylist(rows, schema))

    def close(self) -> None:
        """Delete the temporary file; safe to call twice."""
        self._rows.close()


def _csv_cell(value: Any) -> Any:
    """Return a cell for CSV: true and false as in JSON, nothing for a missing value."""
    return "" if value is None else str(value).lower() if isinstance(value, bool) else value
