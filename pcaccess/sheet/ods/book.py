"""The Calc workbook: its sheets, names, macros and settings in one file.

Names that formulas and macros use: ``PCA_LIVE`` and ``PCA_LAST`` (rows of the linked area now, and when they last were
good), ``PCA_GATEWAY`` and the other settings, ``PCA_MISSING`` (the quality of what is not there).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from pcaccess.items.quality import Quality
from pcaccess.sheet.ods.charts import chart_xml
from pcaccess.sheet.ods.macros import macro, macro_files
from pcaccess.sheet.ods.package import CHART_TYPE, pack
from pcaccess.sheet.ods.sheets import (
    CHART,
    SETTINGS,
    Book,
    chart_sheet,
    data_sheet,
    help_sheet,
    items_sheet,
    line_chart,
    log_sheet,
    settings_sheet,
    write_sheet,
)
from pcaccess.sheet.ods.styles import NAMESPACES, VERSION, styles_xml
from pcaccess.sheet.ods.tables import Column, Layout, Sheet, sheet_xml
from pcaccess.sheet.ods.xml import HEAD, element, text

MAX_ITEMS: Final = 20_000
"""Rows of the linked area that names and formulas reach."""


def ods_book(book: Book) -> bytes:
    """The file. The same book is always the same bytes."""
    layout = Layout()
    chart = line_chart(book)
    sheets = [
        items_sheet(book),
        write_sheet(book),
        chart_sheet(book, chart),
        log_sheet(book),
        help_sheet(book),
        settings_sheet(book),
        data_sheet(book),
        Sheet("Last", [Column(5, repeated=5)], hidden=True),
    ]
    tables = [sheet_xml(sheet, layout) for sheet in sheets]
    listener = {
        "script:language": "ooo:script",
        "script:event-name": "dom:load",
        "xlink:href": macro("Collecting.WhenLoaded"),
        "xlink:type": "simple",
    }
    settings = {
        "table:automatic-find-labels": "false",
        # An item ID is looked up as it is: neither a pattern nor a part.
        "table:use-regular-expressions": "false",
        "table:use-wildcards": "false",
        "table:search-criteria-must-apply-to-whole-cell": "true",
    }
    content = HEAD + element(
        "office:document-content",
        {**NAMESPACES, "xmlns:dom": "http://www.w3.org/2001/xml-events", **VERSION},
        element(
            "office:scripts", None, element("office:event-listeners", None, element("script:event-listener", listener))
        ),
        element("office:automatic-styles", None, layout.xml()),
        element(
            "office:body",
            None,
            element(
                "office:spreadsheet",
                None,
                element("table:calculation-settings", settings),
                *tables,
                element("table:named-expressions", None, *_names()),
            ),
        ),
    )
    files = {
        "content.xml": content,
        "styles.xml": styles_xml(),
        "meta.xml": _meta(book),
        "settings.xml": _views(sheets),
    }
    folders = {}
    if chart is not None:
        files[f"{CHART}/content.xml"] = chart_xml(chart)
        folders[f"{CHART}/"] = CHART_TYPE
    return pack(files | macro_files(), folders)


# ---------------------------------------------------------------------- names, settings, description


def _names() -> list[str]:
    areas = {"PCA_LIVE": f"$Data.$A$1:.$E${MAX_ITEMS + 1}", "PCA_LAST": f"$Last.$A$1:.$E${MAX_ITEMS + 1}"}
    areas |= {f"PCA_{name.upper()}": f"$Settings.$B${n + 2}" for n, name in enumerate(SETTINGS)}
    base = {"table:base-cell-address": "$Items.$A$1"}
    ranges = [
        element("table:named-range", {"table:name": name, "table:cell-range-address": area} | base)
        for name, area in areas.items()
    ]
    known, lost = Quality.CONFIG_ERROR, Quality.COMM_FAILURE
    expressions = {
        "PCA_MISSING": f'of:=IF([$Data.$A$1]="Item ID";{known.code};{lost.code})',
        "PCA_MISSING_NAME": f'of:=IF([$Data.$A$1]="Item ID";"{known.name}";"{lost.name}")',
    }
    return ranges + [
        element("table:named-expression", {"table:name": name, "table:expression": expression} | base)
        for name, expression in expressions.items()
    ]


def _meta(book: Book) -> str:
    return HEAD + element(
        "office:document-meta",
        {**NAMESPACES, **VERSION},
        element(
            "office:meta",
            None,
            element("meta:generator", None, "pcaccess"),
            element("dc:title", None, text(book.title)),
        ),
    )


def _views(sheets: Sequence[Sheet]) -> str:
    """Frozen titles, and no grid where the sheet draws its own lines."""
    tables = []
    for sheet in sheets:
        items = [_config("ShowGrid", "boolean", "true" if sheet.grid else "false")]
        if sheet.frozen:
            items += [
                _config("VerticalSplitMode", "short", "2"),
                _config("VerticalSplitPosition", "int", str(sheet.frozen)),
                _config("ActiveSplitRange", "short", "2"),
                _config("PositionTop", "int", "0"),
                _config("PositionBottom", "int", str(sheet.frozen)),
                _config("CursorPositionY", "int", str(sheet.frozen)),
            ]
        tables.append(element("config:config-item-map-entry", {"config:name": sheet.name}, *items))
    view = element(
        "config:config-item-map-entry",
        None,
        _config("ViewId", "string", "view1"),
        element("config:config-item-map-named", {"config:name": "Tables"}, *tables),
        _config("ActiveTable", "string", sheets[0].name),
    )
    views = element("config:config-item-map-indexed", {"config:name": "Views"}, view)
    return HEAD + element(
        "office:document-settings",
        {**NAMESPACES, **VERSION},
        element(
            "office:settings", None, element("config:config-item-set", {"config:name": "ooo:view-settings"}, views)
        ),
    )


def _config(name: str, kind: str, value: str) -> str:
    return element("config:config-item", {"config:name": name, "config:type": kind}, value)
