"""The Excel workbook of ``sheet new``: WEBSERVICE cells with a tick cell, a sheet that checks writes, a chart, and the
Power Query text that fetches the whole group.

openpyxl cannot embed a query, and a workbook without macros cannot send a PUT: so the query is a text to paste, and a
write is a command to paste. ``sheet collect`` fills a workbook from outside instead.

Source:   names of newer functions need ``_xlfn.`` in the file (ISO/IEC 29500 knows none of them).
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from datetime import datetime
from typing import Final

from openpyxl import Workbook
from openpyxl.chart import BarChart, Reference
from openpyxl.styles import Alignment
from openpyxl.workbook.defined_name import DefinedName
from openpyxl.worksheet.worksheet import Worksheet

from pcaccess.items.quality import Quality
from pcaccess.sheet.entries import Chosen, Entry
from pcaccess.sheet.formulas import excel_quality, excel_value, quoted
from pcaccess.sheet.links import item_path, source_path
from pcaccess.sheet.xlsx import looks

_FIRST: Final = 8
"""Row of the first item."""


def xlsx_book(title: str, gateway: str, chosen: Chosen, now: datetime) -> bytes:
    """The file."""
    workbook = Workbook()
    workbook.properties.title = title
    workbook.properties.creator = "pcaccess"
    workbook.properties.created = workbook.properties.modified = now.replace(tzinfo=None, microsecond=0)
    items: Worksheet = workbook.active  # type: ignore[assignment]
    _items(items, title, gateway, chosen.readable)
    workbook.defined_names["Gateway"] = DefinedName("Gateway", attr_text="Items!$B$3")
    workbook.defined_names["Tick"] = DefinedName("Tick", attr_text="Items!$B$4")
    _write(workbook.create_sheet("Write"), chosen.writable)
    _query(workbook.create_sheet("Power Query"), gateway + source_path(chosen))
    _help(workbook.create_sheet("Help"))
    for sheet in workbook.worksheets:
        looks.printable(sheet)
    buffer = io.BytesIO()
    workbook.save(buffer)
    return buffer.getvalue()


def power_query(url: str) -> list[str]:
    """Lines of the M text that fetches a CSV of the gateway."""
    return [
        "let",
        f"    Source = Csv.Document(Web.Contents({quoted(url)}),",
        '        [Delimiter=",", Encoding=65001, QuoteStyle=QuoteStyle.Csv]),',
        "    Titles = Table.PromoteHeaders(Source, [PromoteAllScalars=true]),",
        '    Typed = Table.TransformColumnTypes(Titles, {{"Item ID", type text}, {"Quality", Int64.Type}, '
        '{"Quality Name", type text}, {"Time Stamp", type datetime}}, "en-US"),',
        '    Values = Table.TransformColumns(Typed, {{"Value", each try Number.FromText(_, "en-US") otherwise _}})',
        "in",
        "    Values",
    ]


def _items(sheet: Worksheet, title: str, gateway: str, entries: Sequence[Entry]) -> None:
    sheet.title = "Items"
    sheet.sheet_properties.tabColor = looks.DARK
    sheet.sheet_view.showGridLines = False
    looks.title(sheet, title, "Press F9 to fetch the values again.")
    settings = [
        ("Gateway", gateway, "where pcaccess serves its web page"),
        ("Tick", "=ROUND(NOW()*86400,0)", "changes at each calculation (F9); write a number here to fetch no more"),
    ]
    for row, (name, setting, what) in enumerate(settings, start=3):
        sheet.cell(row, 1, name)
        sheet.cell(row, 2, setting).fill = looks.INPUT_FILL
        sheet.cell(row, 3, what).font = looks.NOTE
    sheet["B4"].number_format = "0"
    looks.head(sheet, _FIRST - 1, "Item", "Value", "Unit", "Quality", "Quality name", "Description")
    names = ",".join(f'{quality.code},"{quality.name}"' for quality in Quality)
    for row, entry in enumerate(entries, start=_FIRST):
        sheet.cell(row, 1, entry.item_id)
        value = sheet.cell(row, 2, "=" + excel_value(entry))
        value.font = looks.BOLD
        value.alignment = Alignment(horizontal="right")
        if entry.decimals is not None:
            value.number_format = "0." + "0" * entry.decimals if entry.decimals else "0"
        sheet.cell(row, 3, entry.unit)
        sheet.cell(row, 4, "=" + excel_quality(entry)).alignment = Alignment(horizontal="center")
        sheet.cell(row, 5, f'=IFERROR(_xlfn.SWITCH(D{row},{names}),"")')
        sheet.cell(row, 6, entry.description)
        for column in range(1, 7):
            sheet.cell(row, column).border = looks.LINE
    last = max(_FIRST, _FIRST + len(entries) - 1)
    looks.colour_by_quality(sheet, f"B{_FIRST}:E{last}", f"$D{_FIRST}")
    looks.widths(sheet, 36, 24, 9, 10, 28, 44)
    sheet.freeze_panes = f"A{_FIRST}"
    _chart(sheet, entries, last)


def _chart(sheet: Worksheet, entries: Sequence[Entry], last: int) -> None:
    """Bars of the values as they are; texts count as nothing."""
    if not any(entry.is_number for entry in entries):
        return
    chart = BarChart()
    chart.type = "bar"
    chart.title = "Values"
    chart.legend = None
    chart.width, chart.height = 20, max(6.0, min(20.0, 1.2 * (last - _FIRST + 3)))
    chart.add_data(Reference(sheet, min_col=2, min_row=_FIRST, max_row=last))
    chart.set_categories(Reference(sheet, min_col=1, min_row=_FIRST, max_row=last))
    chart.x_axis.delete = chart.y_axis.delete = False
    chart.x_axis.scaling.orientation = "maxMin"
    sheet.add_chart(chart, f"A{last + 3}")


def _write(sheet: Worksheet, entries: Sequence[Entry]) -> None:
    sheet.sheet_properties.tabColor = "D9B93B"
    sheet.sheet_view.showGridLines = False
    looks.title(
        sheet,
        "Write to the PLC",
        "Type a value into a yellow cell: the gateway says whether the item would take it. A workbook without macros "
        "cannot send it; the command does: paste it into a console.",
    )
    looks.head(sheet, 4, "Item", "New value", "Would it be taken?", "Command that writes it", "Type", "Range", "Unit")
    for row, entry in enumerate(entries, start=5):
        sheet.cell(row, 1, entry.item_id)
        new = sheet.cell(row, 2)
        new.fill = looks.INPUT_FILL
        new.alignment = Alignment(horizontal="right")
        # A point as decimal sign in every language of Excel.
        text = f'SUBSTITUTE(B{row}&"",",",".")' if entry.is_number else f"B{row}"
        path = quoted(item_path(entry.item_id, "check") + "?value=")
        asked = f'_xlfn.WEBSERVICE(Gateway&{path}&_xlfn.ENCODEURL({text})&"&tick="&Tick)'
        sheet.cell(row, 3, f'=IF(B{row}="","",IFERROR({asked},"the gateway does not answer"))')
        words = quoted(f" {entry.item_id} ") if " " not in entry.item_id else quoted(f' "{entry.item_id}" ')
        sheet.cell(row, 4, f'=IF(C{row}="ok","pcaccess write"&{words}&{text},"")').font = looks.CODE
        kind = entry.data_type.name if entry.count == 1 else f"{entry.data_type.name}[{entry.count}]"
        for column, cell in enumerate((kind, entry.range_text, entry.unit), start=5):
            sheet.cell(row, column, cell)
        for column in range(1, 8):
            sheet.cell(row, column).border = looks.LINE
    last = max(5, 4 + len(entries))
    looks.colour_good(sheet, f"C5:C{last}", 'C5="ok"')
    looks.colour_bad(sheet, f"C5:C{last}", "LEN(C5)>2")
    looks.widths(sheet, 36, 16, 52, 52, 12, 16, 9)
    sheet.freeze_panes = "A5"


def _query(sheet: Worksheet, url: str) -> None:
    looks.title(sheet, "Power Query", "All items at once, as a table that Excel refreshes by itself.")
    steps = [
        "1. Data, Get Data, From Other Sources, Blank Query; then Advanced Editor.",
        "2. Copy the lines below into it, Done; if Excel asks how to sign in: Anonymous. Close & Load.",
        "3. Data, Queries & Connections, right click, Properties: Refresh every 1 minute (Excel knows no less).",
    ]
    for row, step in enumerate(steps, start=4):
        sheet.cell(row, 1, step)
    for row, line in enumerate(power_query(url), start=8):
        cell = sheet.cell(row, 1, line)
        cell.font, cell.fill = looks.CODE, looks.INPUT_FILL
    looks.widths(sheet, 150)


def _help(sheet: Worksheet) -> None:
    looks.title(sheet, "How this book works")
    lines = [
        "Start pcaccess first (pcaccess run). Its address is the cell Gateway on the sheet Items.",
        "WEBSERVICE cells are fetched by Excel for Windows when the cell Tick changes, that is at F9.",
        "If Excel shows the bar Protected View, permit editing; WEBSERVICE works in trusted workbooks only.",
        "Quality 192 is good; below 64 (red) the value is the last known one; 24: the gateway or PLC does not answer.",
        "To keep rows with time stamps and a chart over time: pcaccess sheet collect log.xlsx --every 1s --for 10min",
        "Excel for the Mac and for the web have no WEBSERVICE; Power Query works in Excel for the Mac.",
        "LibreOffice Calc: take a book.ods instead, which refreshes, logs and writes by itself.",
    ]
    for row, line in enumerate(lines, start=3):
        sheet.cell(row, 1, line)
    looks.widths(sheet, 120)
