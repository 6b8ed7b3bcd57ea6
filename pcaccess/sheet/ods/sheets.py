"""The sheets of the Calc workbook: items with live values, write cells, chart, log, help, settings, linked area."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from pcaccess.sheet.entries import Chosen, Entry
from pcaccess.sheet.formulas import calc_quality, calc_quality_name, calc_time, calc_value, column_letters
from pcaccess.sheet.links import source_path
from pcaccess.sheet.ods.charts import LineChart
from pcaccess.sheet.ods.tables import Button, Cell, Column, Condition, Frame, LinkedArea, Row, Sheet

LOG_ROWS: Final = 200_000
"""Rows that the log keeps; Calc has 1,048,576, but grows slow."""
TREND: Final = 120
"""Rows of the log that the chart shows."""
CHART: Final = "Trend"
_TITLES: Final = 6
"""Rows above the first item of the sheets Items and Write; the macros know it too."""
_QUALITY_RULES: Final = (("{0}<64", "Bad"), ("{0}<192", "Uncertain"))


@dataclass(frozen=True, slots=True)
class Book:
    """What a workbook is made of."""

    title: str
    gateway: str
    """``http://127.0.0.1:8080``."""
    chosen: Chosen
    every: int = 1
    """Seconds between refreshes; Calc knows whole ones only."""


def _value_style(entry: Entry) -> str:
    return "Value" if entry.decimals is None else f"Value {entry.decimals}"


def _by_quality(cells: str, cell: str) -> Condition:
    """Colours by the quality in ``cell`` (as seen from the first of ``cells``)."""
    return Condition(cells, [(rule.format(f"[.{cell}]"), style) for rule, style in _QUALITY_RULES])


def _title_row(*titles: str, right: Sequence[str] = ()) -> Row:
    return Row([Cell(title, "Title row right" if title in right else "Title row") for title in titles], 0.7)


def items_sheet(book: Book) -> Sheet:
    state = (
        'IF(PCA_RUNNING=1;IF([$Data.$A$1]="Item ID";"Collecting every "&PCA_EVERY&" s from "&PCA_GATEWAY;'
        'IF([$Data.$A$1]="";"No data yet: permit that links are updated, then press Start collecting data";'
        '"The gateway "&PCA_GATEWAY&" does not answer. It is asked again; the values are the last known ones"));'
        '"Stopped: the values are those of the last collection")'
    )
    live, last_good = "INDEX(PCA_LIVE;0;5)", "INDEX(PCA_LAST;0;5)"
    newest = f'IF(COUNT({live})>0;MAX({live});IF(COUNT({last_good})>0;MAX({last_good});""))'
    rows = [
        Row([Cell(book.title, "Title", span=7)], 1.0),
        Row([Cell(style="Text", formula=state, span=7)], 0.7),
        Row([Cell("Newest value", "Note"), Cell(style="Time stamp", formula=newest, span=4)], 0.7),
        Row(height=1.2),
        Row(height=0.2),
        _title_row("Item", "Value", "Unit", "Quality", "Quality name", "Time stamp", "Description", right=("Value",)),
    ]
    for n, entry in enumerate(book.chosen.readable):
        key = f"[.$A{_TITLES + 1 + n}]"
        rows.append(
            Row(
                [
                    Cell(entry.item_id, "Text"),
                    Cell(style=_value_style(entry), formula=calc_value(key)),
                    Cell(entry.unit, "Text"),
                    Cell(style="Code", formula=calc_quality(key)),
                    Cell(style="Text", formula=calc_quality_name(key)),
                    Cell(style="Time stamp", formula=calc_time(key)),
                    Cell(entry.description, "Text"),
                ]
            )
        )
    last = max(len(rows), _TITLES + 1)
    buttons = [
        ("Start collecting data", "Collecting.StartCollecting"),
        ("Stop collecting data", "Collecting.StopCollecting"),
        ("Formula wizard …", "Wizards.FormulaWizard"),
        ("Write wizard …", "Wizards.WriteWizard"),
    ]
    return Sheet(
        "Items",
        [Column(8.2), Column(3.4), Column(1.8), Column(2), Column(4.6), Column(4.6), Column(8)],
        rows,
        [Button(label, calls, 0.1 + n * 4.8, 2.6) for n, (label, calls) in enumerate(buttons)],
        [
            Condition(
                "A2:A2",
                [
                    ('LEFT([.A2];10)="Collecting"', "Good"),
                    ('LEFT([.A2];11)="The gateway"', "Bad"),
                    ('LEFT([.A2];2)="No"', "Uncertain"),
                ],
            ),
            _by_quality(f"B7:B{last}", "$D7"),
            _by_quality(f"D7:E{last}", "$D7"),
        ],
        frozen=_TITLES,
        grid=False,
        colour="#1f4e5f",
    )


def write_sheet(book: Book) -> Sheet:
    hint = (
        "Type new values into the yellow cells, then press Write new values. What was written leaves its cell; "
        "what was refused stays, with the reason."
    )
    rows = [
        Row([Cell("Write to the PLC", "Title", span=8)], 1.0),
        Row([Cell(hint, "Note", span=8)], 0.7),
        Row(height=1.2),
        Row(height=0.2),
        Row(height=0.2),
        _title_row(
            "Item", "Now", "New value", "Result", "Type", "Range", "Unit", "Description", right=("Now", "New value")
        ),
    ]
    for n, entry in enumerate(book.chosen.writable):
        key = f"[.$A{_TITLES + 1 + n}]"
        kind = entry.data_type.name if entry.count == 1 else f"{entry.data_type.name}[{entry.count}]"
        rows.append(
            Row(
                [
                    Cell(entry.item_id, "Text"),
                    Cell(style=_value_style(entry), formula=calc_value(key))
                    if entry.readable
                    else Cell("write-only", "Text"),
                    Cell(style="Write cell"),
                    Cell(style="Text"),
                    Cell(kind, "Text"),
                    Cell(entry.range_text, "Text"),
                    Cell(entry.unit, "Text"),
                    Cell(entry.description, "Text"),
                ]
            )
        )
    return Sheet(
        "Write",
        [Column(8.2), Column(3.2), Column(3.2), Column(9.5), Column(2.2), Column(3), Column(1.8), Column(8)],
        rows,
        [
            Button("Write new values", "Writing.WriteNewValues", 0.1, 1.8),
            Button("Write wizard …", "Wizards.WriteWizard", 4.9, 1.8),
        ],
        [
            Condition(
                "D7:D1000",
                [('LEFT([.D7];11)="not written"', "Bad"), ('ISNUMBER(SEARCH(" written at ";[.D7]))', "Good")],
            )
        ],
        frozen=_TITLES,
        grid=False,
        colour="#d9b93b",
    )


def log_sheet(book: Book) -> Sheet:
    entries = book.chosen.readable
    titles = [Cell("Time", "Title row")]
    columns = [Column(4.6)]
    for entry in entries:
        titles += [Cell(entry.item_id, "Title row"), Cell("quality", "Title row")]
        width = max(3.4, min(6.5, 0.24 * len(entry.item_id)))
        columns += [Column(round(width, 1)), Column(1.8)]
    conditions = []
    if entries:
        last = column_letters(2 * len(entries) + 1)
        # Even columns hold values, with their quality to the right; odd ones qualities.
        code = "IF(ISEVEN(COLUMN([.B2]));[.C2];[.B2])"
        rules = [(f"AND(ISNUMBER({code});{rule.format(code)})", style) for rule, style in _QUALITY_RULES]
        conditions.append(Condition(f"B2:{last}{LOG_ROWS + 1}", rules))
    return Sheet("Log", columns, [Row(titles, 1.1)], conditions=conditions, frozen=1, colour="#2e8b57")


_TREND_TITLE: Final = 34
"""Row of the titles of the table below the chart."""


def _charted_columns(book: Book) -> list[tuple[Entry, str]]:
    """Entries of the chart and their columns in the log."""
    readable = book.chosen.readable
    return [(entry, column_letters(2 + 2 * readable.index(entry))) for entry in book.chosen.charted]


def line_chart(book: Book) -> LineChart | None:
    count = len(_charted_columns(book))
    if not count:
        return None
    first, last = _TREND_TITLE + 1, _TREND_TITLE + TREND

    def area(column: int, low: int, high: int) -> str:
        letters = column_letters(column + 1)
        return f"Chart.{letters}{low}:Chart.{letters}{high}"

    lines = [(area(n + 1, _TREND_TITLE, _TREND_TITLE), area(n + 1, first, last)) for n in range(count)]
    return LineChart(area(0, first, last), lines, 27, 15)


def chart_sheet(book: Book, chart: LineChart | None) -> Sheet:
    charted = _charted_columns(book)
    titles = [Cell("Time", "Title row")]
    titles += [Cell(entry.name + (f" [{entry.unit}]" if entry.unit else ""), "Title row") for entry, _ in charted]
    note = f"The last {TREND} rows of the log. The table below the chart feeds it."
    rows = [Row([Cell("Chart", "Title", span=8)], 1.0), Row([Cell(note, "Note", span=8)], 0.7)]
    rows += [Row(repeated=_TREND_TITLE - 3), Row(titles, 0.7)]
    for n in range(1, TREND + 1):
        place = f"PCA_ROWS-{TREND - n}"
        time = f'IF({place}<1;"";INDEX([$Log.$A$2:.$A${LOG_ROWS + 1}];{place}))'
        cells = [Cell(style="Clock", formula=time)]
        for entry, column in charted:
            value = f"INDEX([$Log.${column}$2:.${column}${LOG_ROWS + 1}];{place})"
            formula = f"IF({place}<1;NA();IF(ISNUMBER({value});{value};NA()))"
            cells.append(Cell(style=_value_style(entry), formula=formula))
        rows.append(Row(cells))
    conditions = []
    if charted:
        area = f"B{_TREND_TITLE + 1}:{column_letters(len(charted) + 1)}{_TREND_TITLE + TREND}"
        conditions.append(Condition(area, [(f"ISNA([.B{_TREND_TITLE + 1}])", "Faint")]))
    frame = Frame(CHART, chart.ranges, 0.2, 1.9, chart.width, chart.height) if chart else None
    return Sheet(
        "Chart", [Column(3.2), Column(4, repeated=8)], rows, (), conditions, frame=frame, grid=False, colour="#1f77b4"
    )


def help_sheet(book: Book) -> Sheet:
    lines = [
        ("Title", "How this book works"),
        (
            "Default",
            "Start pcaccess first (pcaccess run), so that the gateway answers. Its address is on the sheet Settings.",
        ),
        (
            "Default",
            "When the book is opened, permit that links are updated and macros run. To be asked no more, put its",
        ),
        ("Default", "folder under Tools, Options, LibreOffice, Security, Macro Security, Trusted Sources."),
        ("Default", ""),
        ("Title row", "Items"),
        (
            "Default",
            "Start and Stop collecting data switch the refresh of values, qualities and time stamps on and off.",
        ),
        (
            "Default",
            "Quality 192 is good. Below 64 (red) the value is the last known one: the PLC or the gateway is gone.",
        ),
        ("Default", "Formula wizard: put the cursor into an empty cell of any sheet, press it, choose items."),
        ("Title row", "Write"),
        ("Default", "A yellow cell for each item that can be written. Nothing is written before Write new values."),
        ("Title row", "Log and Chart"),
        (
            "Default",
            "While collecting, every refresh adds a row to the log (macros must run); the chart shows the last.",
        ),
        ("Default", f"The log ends at {LOG_ROWS:,} rows: save the book under another name, then press Clear log."),
        ("Title row", "Data"),
        (
            "Default",
            "The area that Calc fetches from the gateway; leave it as it is. Formulas find items there by name.",
        ),
    ]
    rows = [Row([Cell(line, style)], 1.0 if style == "Title" else 0.6) for style, line in lines]
    return Sheet("Help", [Column(24)], rows, grid=False, colour="#8c969b")


SETTINGS: Final = ("Gateway", "Source", "Every", "Log", "LogRows", "Running", "Rows")


def settings_sheet(book: Book) -> Sheet:
    source = Cell(source_path(book.chosen), "Setting")
    rows_now = Cell(style="Left", formula=f"COUNT([$Log.$A$2:.$A${LOG_ROWS + 1}])")
    values: list[tuple[str, Cell, str]] = [
        ("Gateway", Cell(book.gateway, "Setting"), "Where pcaccess serves its web page; pcaccess run says it"),
        ("Source", source, "What is collected: a group or a list of items; the wizards extend it"),
        ("Every", Cell(book.every, "Setting"), "Seconds between two refreshes; press Start after a change"),
        ("Log", Cell("yes", "Setting"), "yes: each refresh adds a row to the log; no: it does not"),
        ("LogRows", Cell(LOG_ROWS, "Setting"), "The log ends here"),
        ("Running", Cell(1, "Left"), "1 while collecting; the buttons set it"),
        ("Rows", rows_now, "Rows in the log"),
    ]
    rows = [Row([Cell("Settings", "Title", span=3)], 1.0)]
    rows += [Row([Cell(name, "Text"), cell, Cell(what, "Note")], 0.7) for name, cell, what in values]
    return Sheet(
        "Settings",
        [Column(3.5), Column(14), Column(16)],
        rows,
        [Button("Clear log …", "Collecting.ClearLog", 0.1, 6.4)],
        grid=False,
        colour="#8c969b",
    )


def data_sheet(book: Book) -> Sheet:
    linked = LinkedArea(book.gateway + source_path(book.chosen), book.every, len(book.chosen.readable) + 1, 5)
    widths = (8.2, 4, 2, 5)
    return Sheet("Data", [*map(Column, widths), Column(4.6, "Time stamp")], linked=linked, colour="#8c969b")
