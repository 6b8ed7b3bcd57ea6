"""How the cells of our Excel workbooks look; the same colours as in Calc."""

from __future__ import annotations

from typing import Any, Final

from openpyxl.formatting.rule import Rule
from openpyxl.styles import Alignment, Border, Font, PatternFill, Side
from openpyxl.styles.differential import DifferentialStyle
from openpyxl.worksheet.properties import PageSetupProperties
from openpyxl.worksheet.worksheet import Worksheet

DARK: Final = "1F4E5F"
TITLE: Final = Font(name="Calibri", size=16, bold=True, color=DARK)
NOTE: Final = Font(name="Calibri", size=10, color="5B6B73")
BOLD: Final = Font(name="Calibri", size=11, bold=True)
HEAD: Final = Font(name="Calibri", size=11, bold=True, color="FFFFFF")
CODE: Final = Font(name="Consolas", size=10)
HEAD_FILL: Final = PatternFill("solid", start_color=DARK)
INPUT_FILL: Final = PatternFill("solid", start_color="FFF6CC")
LINE: Final = Border(bottom=Side(style="hair", color="B8C4CA"))

_BAD: Final = DifferentialStyle(Font(bold=True, color="A01522"), fill=PatternFill("solid", bgColor="F9D6D9"))
_UNCERTAIN: Final = DifferentialStyle(Font(color="7A5600"), fill=PatternFill("solid", bgColor="FFF0C2"))
_GOOD: Final = DifferentialStyle(Font(color="1B6E3C"), fill=PatternFill("solid", bgColor="DFF3E4"))


def printable(sheet: Worksheet) -> None:
    """Landscape and one page wide."""
    sheet.page_setup.orientation = "landscape"
    sheet.page_setup.paperSize = 9  # A4
    sheet.page_setup.fitToHeight = 0
    sheet.sheet_properties.pageSetUpPr = PageSetupProperties(fitToPage=True)


def title(sheet: Worksheet, text: str, note: str = "") -> None:
    """In the first two rows."""
    sheet["A1"] = text
    sheet["A1"].font = TITLE
    sheet.row_dimensions[1].height = 26
    sheet["A2"] = note
    sheet["A2"].font = NOTE


def head(sheet: Worksheet, row: int, *titles: str) -> None:
    """A row of column titles."""
    for column, text in enumerate(titles, start=1):
        head_cell(sheet.cell(row, column, text))
    sheet.row_dimensions[row].height = 22


def head_cell(cell: Any) -> None:
    cell.font, cell.fill = HEAD, HEAD_FILL
    cell.alignment = Alignment(vertical="center", wrap_text=True)


def widths(sheet: Worksheet, *characters: float) -> None:
    """Of the first columns."""
    for n, width in enumerate(characters):
        sheet.column_dimensions[chr(65 + n)].width = width


def colour_by_quality(sheet: Worksheet, cells: str, code: str) -> None:
    """``code``: the quality as a formula seen from the first of ``cells``. An empty one has no colour."""
    for bound, look in ((64, _BAD), (192, _UNCERTAIN)):
        _colour(sheet, cells, f"AND(ISNUMBER({code}),{code}<{bound})", look)


def colour_good(sheet: Worksheet, cells: str, formula: str) -> None:
    _colour(sheet, cells, formula, _GOOD)


def colour_bad(sheet: Worksheet, cells: str, formula: str) -> None:
    _colour(sheet, cells, formula, _BAD)


def _colour(sheet: Worksheet, cells: str, formula: str, look: DifferentialStyle) -> None:
    sheet.conditional_formatting.add(cells, Rule(type="expression", dxf=look, formula=[formula], stopIfTrue=True))
