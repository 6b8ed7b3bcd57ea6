"""The workbook that ``sheet collect`` fills: an empty one with its looks, made by openpyxl; and what one holds already.

Sheets: Values, Qualities and Time Stamps have the same columns and, row by row, belong together; Chart shows the last
rows of Values; Items says what the items are; Runs what happened.
"""

from __future__ import annotations

import zipfile
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import Any, BinaryIO, Final
from xml.etree.ElementTree import ParseError

from openpyxl import Workbook, load_workbook
from openpyxl.chart import LineChart, Reference
from openpyxl.packaging.custom import StringProperty
from openpyxl.utils.exceptions import InvalidFileException
from openpyxl.worksheet.worksheet import Worksheet

from pcaccess.sheet.collect.append import PROPERTY, DamagedBook
from pcaccess.sheet.entries import Chosen, Entry, SheetError
from pcaccess.sheet.formulas import column_letters
from pcaccess.sheet.xlsx import looks

VALUES: Final = "Values"
QUALITIES: Final = "Qualities"
TIMES: Final = "Time Stamps"
RUNS: Final = "Runs"
GROWING: Final = (VALUES, QUALITIES, TIMES)
MAX_ITEMS: Final = 2000
"""Columns beyond that nobody reads, and Excel ends at 16,384."""
STAMP: Final = "yyyy-mm-dd hh:mm:ss.000"
TREND: Final = 300
"""Rows that the chart shows."""
_FIRST: Final = 40
"""Row of the titles of the table below the chart."""


def write_empty(target: BinaryIO, chosen: Chosen, gateway: str, now: datetime) -> None:
    """A workbook without rows."""
    entries = chosen.readable
    if len(entries) > MAX_ITEMS:
        raise SheetError(f"{len(entries):,} items are too many for one workbook; at most {MAX_ITEMS:,}")
    workbook = Workbook()
    workbook.properties.creator = "pcaccess"
    workbook.properties.title = f"Collected from {gateway}"
    workbook.properties.created = workbook.properties.modified = now.replace(tzinfo=None, microsecond=0)
    properties: Any = workbook  # openpyxl's annotations do not know its custom properties
    properties.custom_doc_props.append(StringProperty(name=PROPERTY, value="-"))
    workbook.calculation.fullCalcOnLoad = True
    values: Worksheet = workbook.active  # type: ignore[assignment]
    values.title = VALUES
    for sheet, colour in ((values, looks.DARK), (workbook.create_sheet(QUALITIES), "2E8B57")):
        _columns(sheet, entries, colour)
    _columns(workbook.create_sheet(TIMES), entries, "2E8B57", STAMP)
    if entries:
        # Row by row, the quality of a value stands at the same place of the other sheet.
        last = column_letters(len(entries) + 1)
        looks.colour_by_quality(values, f"B2:{last}1048576", f"{QUALITIES}!B2")
        looks.colour_by_quality(workbook[QUALITIES], f"B2:{last}1048576", "B2")
    _chart(workbook.create_sheet("Chart", 1), chosen)
    _items(workbook.create_sheet("Items"), entries)
    _runs(workbook.create_sheet(RUNS))
    for sheet in workbook.worksheets:
        looks.printable(sheet)
    workbook.save(target)


def items_of(book: Path) -> list[str]:
    """IDs of the items that a workbook has columns for. Raises SheetError when it is not one of ours."""
    try:
        workbook = load_workbook(book, read_only=True)
    except PermissionError as error:
        raise SheetError(f"{book} cannot be read: {error.strerror}; is it open in another program?") from None
    except OSError as error:
        raise SheetError(f"{book} cannot be read: {error.strerror or error}") from None
    except (InvalidFileException, zipfile.BadZipFile, KeyError, ValueError, ParseError, TypeError, EOFError) as error:
        raise DamagedBook(
            f"{book} is damaged or no .xlsx workbook ({error}); it stays as it is: rename it, or name another file"
        ) from None
    try:
        missing = [name for name in (*GROWING, RUNS) if name not in workbook.sheetnames]
        if missing:
            raise SheetError(
                f"{book} was not made by `pcaccess sheet collect` (it has no sheet {missing[0]}); name another file"
            )
        titles = next(workbook[VALUES].iter_rows(max_row=1, values_only=True), ())
        return [str(title) for title in titles[1:] if title is not None]
    finally:
        workbook.close()


def _columns(sheet: Worksheet, entries: Sequence[Entry], colour: str, number_format: str | None = None) -> None:
    sheet.sheet_properties.tabColor = colour
    for column, text in enumerate(["Time", *(entry.item_id for entry in entries)], start=1):
        looks.head_cell(sheet.cell(1, column, text))
        width = sheet.column_dimensions[column_letters(column)]
        width.width = 24 if column == 1 or number_format else max(14, min(40, len(text) * 1.25))
        wanted = STAMP if column == 1 else number_format
        if wanted is None and sheet.title == VALUES and (digits := entries[column - 2].decimals) is not None:
            wanted = "0." + "0" * digits if digits else "0"
        if wanted is not None:
            width.number_format = wanted
    sheet.row_dimensions[1].height = 34
    sheet.freeze_panes = "B2"


def _chart(sheet: Worksheet, chosen: Chosen) -> None:
    """The last rows, looked up by formulas, so that nothing in the chart changes when rows come."""
    sheet.sheet_properties.tabColor = "1F77B4"
    sheet.sheet_view.showGridLines = False
    looks.title(sheet, "Chart", f"The last {TREND} rows of the sheet {VALUES}.")
    # NOW makes Excel calculate it when it opens the file, although nothing in the file says that anything changed.
    sheet["J1"] = "Rows"
    sheet["J1"].font = looks.NOTE
    sheet["K1"] = f"=COUNT({VALUES}!A:A)+0*NOW()"
    sheet["K1"].number_format = "0"
    charted = chosen.charted
    looks.head(sheet, _FIRST, "Time", *(entry.name + (f" [{entry.unit}]" if entry.unit else "") for entry in charted))
    readable = chosen.readable
    for n in range(1, TREND + 1):
        row, place = _FIRST + n, f"$K$1-{TREND - n}+1"
        stamp = sheet.cell(row, 1, f'=IF({place}<2,"",INDEX({VALUES}!A:A,{place}))')
        stamp.number_format = "hh:mm:ss"
        for column, entry in enumerate(charted, start=2):
            letters = column_letters(readable.index(entry) + 2)
            value = f"INDEX({VALUES}!{letters}:{letters},{place})"
            sheet.cell(row, column, f"=IF({place}<2,NA(),IF(ISNUMBER({value}),{value},NA()))")
    looks.widths(sheet, 14, *[16] * len(charted))
    if not charted:
        return
    chart: Any = LineChart()  # the annotations know less than openpyxl does
    chart.width, chart.height = 30, 16
    chart.legend.position = "b"
    chart.add_data(
        Reference(sheet, min_col=2, max_col=1 + len(charted), min_row=_FIRST, max_row=_FIRST + TREND),
        titles_from_data=True,
    )
    chart.set_categories(Reference(sheet, min_col=1, min_row=_FIRST + 1, max_row=_FIRST + TREND))
    chart.x_axis.delete = chart.y_axis.delete = False
    chart.x_axis.number_format = "hh:mm:ss"
    chart.x_axis.tickLblSkip = chart.x_axis.tickMarkSkip = TREND // 10
    for line in chart.series:
        line.smooth = False
        line.marker.symbol = "none"
    sheet.add_chart(chart, "A4")


def _items(sheet: Worksheet, entries: Sequence[Entry]) -> None:
    looks.head(sheet, 1, "Item", "Type", "Range", "Unit", "Description")
    for row, entry in enumerate(entries, start=2):
        kind = entry.data_type.name if entry.count == 1 else f"{entry.data_type.name}[{entry.count}]"
        for column, text in enumerate((entry.item_id, kind, entry.range_text, entry.unit, entry.description), start=1):
            cell = sheet.cell(row, column)
            cell.value = text
            cell.data_type = "s"  # a text that begins with = is a text
    looks.widths(sheet, 36, 12, 16, 10, 50)
    sheet.freeze_panes = "A2"


def _runs(sheet: Worksheet) -> None:
    looks.head(sheet, 1, "Time", "What happened")
    looks.widths(sheet, 24, 100)
    sheet.column_dimensions["A"].number_format = STAMP
    sheet.freeze_panes = "A2"
