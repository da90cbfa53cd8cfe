"""Encoder counts that the exported code expects: sign, conversion, and absence of jumps.

    position = direction * resolution * counts

If `columns.position` of the bench has the unit `count`, the counts are scale * (number in the log)
+ offset, with the scale and offset of this column. A wrong sign would make the feedback positive.
"""

from __future__ import annotations

from frictool.documents.bench import Column
from frictool.documents.controller import Controller
from frictool.documents.quantity import si_unit

COUNT = "count"
CHECK = "before you close the loop, check that the position grows during forward motion"


def reading_notes(controller: Controller) -> dict[str, str]:
    """Return notes on the encoder's reading, by subject (`counts` or `index`).

    The result is empty if the counts grow during forward motion, and if neither `columns.position`
    (scale, offset) nor an index pulse changes the counts.
    """
    encoder = controller.bench.encoder
    notes = {}
    column = controller.bench.columns.get("position")
    source = _source(column, encoder.direction)
    if source or encoder.direction < 0:
        change = "grow" if encoder.direction > 0 else "decrease"
        unit = si_unit("position", controller.axis)
        notes["counts"] = (
            f"{change} during forward motion (encoder.direction: {encoder.direction}); "
            f"{encoder.position_per_count:.6g} {unit} per count{source}"
        )
    if encoder.index_reset:
        notes["index"] = (
            "an index pulse resets the counter (encoder.index_reset); the position must be "
            "continuous, without the jumps of the reset"
        )
    return notes


def _source(column: Column | None, direction: int) -> str:
    """Return a text that relates the bench's column to the counts; "" if none is needed."""
    if column is None:
        return f"; {CHECK}" if direction < 0 else ""
    if column.unit != COUNT:
        if direction > 0 and column.scale > 0.0:
            return ""
        sign = " with a negative scale" if column.scale < 0.0 else ""
        return f"; columns.position is in {column.unit}{sign}, not in counts: {CHECK}"
    if (column.scale, column.offset) != (1.0, 0.0):
        return (
            f"; counts = {column.scale:.15g} x (number in the file) + {column.offset:.15g}, as in "
            "columns.position of the bench"
        )
    return ", with the counts of columns.position in the bench" if direction < 0 else ""
