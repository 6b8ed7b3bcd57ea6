"""Sheets of an OpenDocument spreadsheet: cells, columns, buttons, conditions, a linked area, a chart's frame.

Units:    lengths in cm, times in seconds.
Source:   OpenDocument 1.3 part 3; the ``calcext`` and ``officeooo`` elements as LibreOffice 7.4 writes them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

from pcaccess.sheet.ods.macros import macro
from pcaccess.sheet.ods.styles import style_name
from pcaccess.sheet.ods.xml import element, text

CSV_FILTER: Final = "Text - txt - csv (StarCalc)"
CSV_OPTIONS: Final = "44,34,76,1,,1033,false,true,false,false,false,-1"
"""Commas, quotes, UTF-8, from line 1, English (US), numbers and times are recognised."""


@dataclass(frozen=True, slots=True)
class Cell:
    value: str | float | None = None
    style: str | None = None
    """Display name of a cell style; None takes the column's."""
    formula: str | None = None
    """Without the sign of equality, in Calc's own (English) words."""
    span: int = 1
    """Columns that it covers."""


@dataclass(frozen=True, slots=True)
class Row:
    cells: Sequence[Cell] = ()
    height: float = 0.55
    repeated: int = 1


@dataclass(frozen=True, slots=True)
class Column:
    width: float
    style: str = "Default"
    repeated: int = 1


@dataclass(frozen=True, slots=True)
class Button:
    """Calls ``Module.Sub`` of the document's macros."""

    label: str
    calls: str
    x: float
    y: float
    width: float = 4.6
    height: float = 0.8


@dataclass(frozen=True, slots=True)
class Condition:
    """Cells that look like a style where its formula (seen from the first of them) holds; the first that does wins."""

    cells: str
    """``A7:A20`` of the sheet."""
    rules: Sequence[tuple[str, str]]
    """Formula and style."""


@dataclass(frozen=True, slots=True)
class LinkedArea:
    """A CSV that Calc fetches again and again."""

    url: str
    every: int
    rows: int
    columns: int


@dataclass(frozen=True, slots=True)
class Frame:
    """A chart: a folder of the package, and the ranges it shows (``Sheet.A1:Sheet.B9``)."""

    folder: str
    ranges: Sequence[str]
    x: float
    y: float
    width: float
    height: float


@dataclass(slots=True)
class Sheet:
    name: str
    columns: Sequence[Column]
    rows: list[Row] = field(default_factory=list)
    buttons: Sequence[Button] = ()
    conditions: Sequence[Condition] = ()
    linked: LinkedArea | None = None
    frame: Frame | None = None
    frozen: int = 0
    """Rows at the top that stay in view."""
    grid: bool = True
    hidden: bool = False
    colour: str = ""
    """Of the tab."""


class Layout:
    """Automatic styles that columns, rows and tables need, each made once."""

    def __init__(self) -> None:
        self._made: dict[tuple[str, str], str] = {}

    def width(self, cm: float) -> str:
        return self._style(
            "co", "table-column", element("style:table-column-properties", {"style:column-width": f"{cm}cm"})
        )

    def height(self, cm: float) -> str:
        properties = {"style:row-height": f"{cm}cm", "style:use-optimal-row-height": "false"}
        return self._style("ro", "table-row", element("style:table-row-properties", properties))

    def table(self, *, hidden: bool, colour: str) -> str:
        properties = {"table:display": "false" if hidden else "true", "table:tab-color": colour or None}
        return self._style("ta", "table", element("style:table-properties", properties))

    def _style(self, prefix: str, family: str, properties: str) -> str:
        key = (family, properties)
        if key not in self._made:
            self._made[key] = f"{prefix}{sum(known == family for known, _ in self._made) + 1}"
        return self._made[key]

    def xml(self) -> str:
        styles = []
        for (family, properties), name in self._made.items():
            master = "Default" if family == "table" else None
            named = {"style:name": name, "style:family": f"{family}", "style:master-page-name": master}
            styles.append(element("style:style", named, properties))
        return "".join(styles)


def sheet_xml(sheet: Sheet, layout: Layout) -> str:
    """The ``table:table`` of a sheet."""
    return element(
        "table:table",
        {"table:name": sheet.name, "table:style-name": layout.table(hidden=sheet.hidden, colour=sheet.colour)},
        _forms(sheet),
        _shapes(sheet),
        *(_column(column, layout) for column in sheet.columns),
        *_rows(sheet, layout),
        _conditions(sheet),
    )


def _column(column: Column, layout: Layout) -> str:
    return element(
        "table:table-column",
        {
            "table:style-name": layout.width(column.width),
            "table:number-columns-repeated": column.repeated if column.repeated > 1 else None,
            "table:default-cell-style-name": style_name(column.style),
        },
    )


def _rows(sheet: Sheet, layout: Layout) -> list[str]:
    rows = sheet.rows or [Row((Cell(),))]
    linked = _linked(sheet.linked) if sheet.linked is not None else ""
    return [_row(row, layout, linked if n == 0 else "") for n, row in enumerate(rows)]


def _row(row: Row, layout: Layout, linked: str) -> str:
    cells = [_cell(cell, linked if n == 0 else "") for n, cell in enumerate(row.cells or (Cell(),))]
    return element(
        "table:table-row",
        {
            "table:style-name": layout.height(row.height),
            "table:number-rows-repeated": row.repeated if row.repeated > 1 else None,
        },
        *cells,
    )


def _cell(cell: Cell, linked: str = "") -> str:
    attributes: dict[str, object] = {}
    if cell.style is not None:
        attributes["table:style-name"] = style_name(cell.style)
    if cell.span > 1:
        attributes |= {"table:number-columns-spanned": cell.span, "table:number-rows-spanned": 1}
    content = linked
    if cell.formula is not None:
        attributes["table:formula"] = f"of:={cell.formula}"
    elif isinstance(cell.value, str):
        attributes["office:value-type"] = "string"
        content += element("text:p", None, text(cell.value))
    elif cell.value is not None:
        attributes |= {"office:value-type": "float", "office:value": f"{cell.value:g}"}
    covered = "<table:covered-table-cell/>" * (cell.span - 1)
    return element("table:table-cell", attributes, content) + covered


def _linked(area: LinkedArea) -> str:
    return element(
        "table:cell-range-source",
        {
            "table:name": "CSV_all",
            "xlink:type": "simple",
            "xlink:href": area.url,
            "table:filter-name": CSV_FILTER,
            "table:filter-options": CSV_OPTIONS,
            "table:last-column-spanned": area.columns,
            "table:last-row-spanned": area.rows,
            "table:refresh-delay": f"PT{area.every // 3600:02}H{area.every // 60 % 60:02}M{area.every % 60:02}S",
        },
    )


def _control_id(sheet: Sheet, button: Button) -> str:
    return f"{sheet.name}.{button.calls}"


def _forms(sheet: Sheet) -> str:
    if not sheet.buttons:
        return ""
    buttons = [
        element(
            "form:button",
            {
                "form:name": button.calls,
                "form:control-implementation": "ooo:com.sun.star.form.component.CommandButton",
                "xml:id": _control_id(sheet, button),
                "form:id": _control_id(sheet, button),
                "form:label": button.label,
                "office:target-frame": "",
            },
            element(
                "office:event-listeners",
                None,
                element(
                    "script:event-listener",
                    {
                        "script:language": "ooo:script",
                        "script:event-name": "form:performaction",
                        "xlink:href": macro(button.calls),
                        "xlink:type": "simple",
                    },
                ),
            ),
        )
        for button in sheet.buttons
    ]
    form = {
        "form:name": "Buttons",
        "form:apply-filter": "true",
        "form:control-implementation": "ooo:com.sun.star.form.component.Form",
        "office:target-frame": "",
    }
    return element(
        "office:forms",
        {"form:automatic-focus": "false", "form:apply-design-mode": "false"},
        element("form:form", form, *buttons),
    )


def _shapes(sheet: Sheet) -> str:
    shapes = [
        element("draw:control", _place(button) | {"draw:z-index": n, "draw:control": _control_id(sheet, button)})
        for n, button in enumerate(sheet.buttons)
    ]
    if sheet.frame is not None:
        target = {
            "draw:notify-on-update-of-ranges": " ".join(sheet.frame.ranges),
            "xlink:href": f"./{sheet.frame.folder}",
            "xlink:type": "simple",
            "xlink:show": "embed",
            "xlink:actuate": "onLoad",
        }
        shapes.append(element("draw:frame", _place(sheet.frame) | {"draw:z-index": 99}, element("draw:object", target)))
    return element("table:shapes", None, *shapes) if shapes else ""


def _place(shape: Button | Frame) -> dict[str, object]:
    lengths = {"svg:x": shape.x, "svg:y": shape.y, "svg:width": shape.width, "svg:height": shape.height}
    return {name: f"{length}cm" for name, length in lengths.items()}


def _conditions(sheet: Sheet) -> str:
    if not sheet.conditions:
        return ""
    formats = []
    for condition in sheet.conditions:
        first, _, last = condition.cells.partition(":")
        rules = [
            element(
                "calcext:condition",
                {
                    "calcext:apply-style-name": style_name(style),
                    "calcext:value": f"formula-is({formula})",
                    "calcext:base-cell-address": f"{sheet.name}.{first}",
                },
            )
            for formula, style in condition.rules
        ]
        area = f"{sheet.name}.{first}:{sheet.name}.{last or first}"
        formats.append(element("calcext:conditional-format", {"calcext:target-range-address": area}, *rules))
    return element("calcext:conditional-formats", None, *formats)
