"""PC Access projects: a ``.pca`` is a Jet 4 database, read with access-parser.

Tables: TagList (items, with their run-time names), PathList (``Microwin.Project1.USER1``: link, PLC, folders),
PropertyList (101 description, 102 high, 103 low; texts padded with blanks), DISTCONF (how many items there are).

Errors:   TextError when the file is no PC Access project or is damaged.
Source:   two real files; reference notes, PC Access facts.
"""

from __future__ import annotations

import logging
import math
import struct
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from access_parser import AccessParser  # type: ignore[import-untyped]

from pcaccess.problems import Span
from pcaccess.project.importers.draft import Draft, DraftItem, DraftPlc
from pcaccess.project.itemtext import ItemText
from pcaccess.project.names import ANY_IP, RunTimeName, RunTimeNameError, parse_run_time_name
from pcaccess.project.textfile import TextError

SIGNATURE: Final = b"\x00\x01\x00\x00Standard Jet DB"
_PAGE: Final = 4096
_TABLE_DEFINITION: Final = 0x02
_ITEM: Final = 2  # TagType; 0 is the root, 1 a folder
_VARTYPES: Final = {
    2: "INT",
    3: "DINT",
    4: "REAL",
    8: "STRING",
    11: "BOOL",
    16: "CHAR",
    17: "BYTE",
    18: "WORD",
    19: "DWORD",
}
_ACCESS: Final = {1: "R", 2: "W", 3: "RW"}
_DESCRIPTION, _HIGH, _LOW = 101, 102, 103
_DAMAGED: Final = "the database is damaged; open it in PC Access and save it again"


def read_pca(path: Path, data: bytes) -> Draft:
    """Links, PLCs, folders and items of a PC Access project."""
    tables = _tables(path, data)
    paths = {row["PATHID"]: (row.get("Path") or "").strip() for row in tables["PathList"]}
    properties = _properties(tables["PropertyList"])
    draft = Draft(str(path), f"the PC Access project {path.name}")
    plcs: dict[str, DraftPlc] = {}
    for full in paths.values():
        _plc_of(full.split("."), plcs)
    span = Span(str(path), 1, 1)
    count = 0
    for row in tables["TagList"]:
        if row.get("TagType") != _ITEM:
            continue
        count += 1
        full = paths.get(row.get("PathID"), "")
        where = f"{full}.{row.get('ShortName')}"
        plc = _plc_of(full.split("."), plcs)
        if plc is None:
            draft.leave_out("PRJ014", span, "the item belongs to no PLC", where)
            continue
        item = _item(row, properties.get(row["TAG_ID"], {}), plc, draft, DraftItem((), ItemText("", ""), span, where))
        if item is not None:
            item.folders = tuple(full.split(".")[2:])
            plc.items.append(item)
    _compare_count(tables["DISTCONF"], count, draft, span)
    draft.plcs = list(plcs.values())
    return draft


def _tables(path: Path, data: bytes) -> dict[str, list[dict[str, Any]]]:
    if not data.startswith(SIGNATURE):
        raise TextError("this is not a PC Access project")
    if len(data) % _PAGE:
        raise TextError("the file is cut off; copy it again from where it came from")
    _check_pages(data)
    with _quiet():
        try:
            database = AccessParser(str(path))
            names = set(database.catalog)
            found = {
                name: _rows(database.parse_table(name)) if name in names else []
                for name in ("TagList", "PathList", "PropertyList", "DISTCONF")
            }
        except Exception:  # the parser trusts every byte; whatever it trips over is damage
            raise TextError(_DAMAGED) from None
    if "TagList" not in names or "PathList" not in names:
        raise TextError("this is an Access database, but not a PC Access project")
    for name, key in (("TagList", "TAG_ID"), ("PathList", "PATHID"), ("PropertyList", "TAG_ID")):
        if any(key not in row for row in found[name]):
            raise TextError(_DAMAGED)
    return found


def _check_pages(data: bytes) -> None:
    """The definition of a table may run over several pages; access-parser would follow a circle for ever."""
    for start in range(0, len(data), _PAGE):
        if data[start] != _TABLE_DEFINITION:
            continue
        at, steps = start, 0
        while (following := struct.unpack_from("<I", data, at + 4)[0]) != 0:
            at, steps = following * _PAGE, steps + 1
            if at >= len(data) or data[at] != _TABLE_DEFINITION or steps > len(data) // _PAGE:
                raise TextError(_DAMAGED)


@contextmanager
def _quiet() -> Iterator[None]:
    """access-parser logs what it cannot read page by page; the user gets one sentence instead."""
    logger = logging.getLogger("access_parser")
    before = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        logger.setLevel(before)


def _rows(columns: Mapping[str, list[Any]]) -> list[dict[str, Any]]:
    """Rows of a table that comes as columns; a damaged one has columns of different length."""
    lengths = {len(values) for values in columns.values()}
    if len(lengths) > 1:
        raise TextError(_DAMAGED)
    return [dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True)]


def _properties(rows: list[dict[str, Any]]) -> dict[int, dict[int, str]]:
    found: dict[int, dict[int, str]] = {}
    for row in rows:
        found.setdefault(row["TAG_ID"], {})[row.get("PROPERTY_ID", 0)] = str(row.get("Value") or "").strip()
    return found


def _plc_of(parts: list[str], plcs: dict[str, DraftPlc]) -> DraftPlc | None:
    """The PLC that a path leads to or through; new when it is the first of that name."""
    if len(parts) < 2:
        return None
    key = ".".join(parts[:2]).casefold()
    if key not in plcs:
        plcs[key] = DraftPlc(parts[0], parts[1])
    return plcs[key]


def _item(
    row: dict[str, Any], properties: dict[int, str], plc: DraftPlc, draft: Draft, item: DraftItem
) -> DraftItem | None:
    try:
        name = parse_run_time_name(str(row.get("RuntimeName") or ""))
    except RunTimeNameError as error:
        draft.leave_out("PRJ017", item.span, str(error), item.where)
        return None
    _note_station(name, plc, draft, item)
    data_type = name.data_type.name if name.data_type else _VARTYPES.get(row.get("DataType") or 0)
    access = str(name.access) if name.access else _ACCESS.get(row.get("AccessRights") or 0)
    high = _number(properties.get(_HIGH), name.high)
    low = _number(properties.get(_LOW), name.low)
    item.text = ItemText(
        str(row.get("ShortName") or ""),
        str(name.address),
        data_type,
        access,
        high,
        low,
        description=" ".join(properties.get(_DESCRIPTION, "").split()),
    )
    return item


def _note_station(name: RunTimeName, plc: DraftPlc, draft: Draft, item: DraftItem) -> None:
    """The address of a PLC stands in the run-time names of its items and nowhere else."""
    if plc.address is None:
        plc.address = name.station
        if name.ip not in (None, ANY_IP):
            tsaps = f"{name.local_tsap >> 8:02X}.{name.local_tsap & 255:02X}"
            remote = f"{name.remote_tsap >> 8:02X}.{name.remote_tsap & 255:02X}"
            plc.notes.append(f'In PC Access: host: {name.ip}, local_tsap: "{tsaps}", remote_tsap: "{remote}"')
    elif plc.address != name.station:
        message = f"station {name.station}, while its PLC is station {plc.address}; the PLC's counts"
        draft.warn("PRJ036", item.span, message, item.where)


def _number(text: str | None, otherwise: float | None) -> float | None:
    try:
        value = float(text) if text else math.nan
    except ValueError:
        value = math.nan
    return value if math.isfinite(value) else otherwise


def _compare_count(rows: list[dict[str, Any]], count: int, draft: Draft, span: Span) -> None:
    """DISTCONF says how many items PC Access wrote."""
    for row in rows:
        if str(row.get("Protocol") or "").strip().casefold() == "microwin:" and row.get("Count") != count:
            draft.warn("PRJ001", span, f"the project says it has {row.get('Count')} items, and {count} could be read")
