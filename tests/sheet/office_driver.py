"""Drives LibreOffice over UNO for test_calc.py. Runs under the Python that has ``uno`` (Debian's own), not the tests'.

One JSON list per line comes in, [command, arguments…]; one JSON value per line goes out, or {"error": "…"}.
"""

from __future__ import annotations

import contextlib
import json
import sys
import time
from typing import Any

import uno  # type: ignore[import-not-found]

PATIENCE = 90.0
"""Seconds; an office that starts for the first time on a busy machine takes some."""


def connect(pipe: str) -> Any:
    local = uno.getComponentContext()
    resolver = local.ServiceManager.createInstanceWithContext("com.sun.star.bridge.UnoUrlResolver", local)
    end = time.monotonic() + PATIENCE
    while True:
        try:
            context = resolver.resolve(f"uno:pipe,name={pipe};urp;StarOffice.ComponentContext")
            return context.ServiceManager.createInstanceWithContext("com.sun.star.frame.Desktop", context)
        except Exception:
            if time.monotonic() > end:
                raise
            time.sleep(0.2)


def option(name: str, value: Any) -> Any:
    made = uno.createUnoStruct("com.sun.star.beans.PropertyValue")
    made.Name, made.Value = name, value
    return made


class Driver:
    """The commands: one document at a time."""

    def __init__(self, desktop: Any) -> None:
        self.desktop = desktop
        self.doc: Any = None

    def open(self, path: str) -> bool:
        # Macros as the profile says (a trusted folder), and never a question; links are updated.
        options = (option("Hidden", True), option("MacroExecutionMode", 5), option("UpdateDocMode", 3))
        self.doc = self.desktop.loadComponentFromURL(uno.systemPathToFileUrl(path), "_blank", 0, options)
        return self.doc is not None

    def trusted(self) -> bool:
        """Whether LibreOffice lets the buttons call macros; what UNO calls it does not ask."""
        return bool(self.doc.AllowMacroExecution)

    def save(self) -> None:
        self.doc.store()

    def close(self) -> None:
        if self.doc is not None:
            self.doc.close(True)
            self.doc = None

    def macro(self, name: str, *arguments: Any) -> Any:
        where = f"vnd.sun.star.script:Standard.{name}?language=Basic&location=document"
        cells = tuple(self._cell(a[1]) if isinstance(a, list) and a[:1] == ["cell"] else a for a in arguments)
        given = tuple(tuple(a) if isinstance(a, list) else a for a in cells)
        result = self.doc.getScriptProvider().getScript(where).invoke(given, (), ())[0]
        return list(result) if isinstance(result, tuple) else result

    def shown(self, area: str) -> list[list[str]]:
        """What stands in the cells, as a reader sees it."""
        cells = self._cell(area)
        place = cells.RangeAddress
        return [
            [cells.getCellByPosition(column, row).String for column in range(place.EndColumn - place.StartColumn + 1)]
            for row in range(place.EndRow - place.StartRow + 1)
        ]

    def wait(self, area: str, wanted: list[list[str]]) -> list[list[str]]:
        """Until the cells show just that; what they show then."""
        end = time.monotonic() + PATIENCE
        while (shown := self.shown(area)) != wanted and time.monotonic() < end:
            time.sleep(0.05)
        return shown

    def wait_other(self, area: str, old: list[list[str]]) -> list[list[str]]:
        """Until the cells show anything else."""
        end = time.monotonic() + PATIENCE
        while (shown := self.shown(area)) == old and time.monotonic() < end:
            time.sleep(0.05)
        return shown

    def pause(self, seconds: float) -> None:
        """For what shall not happen."""
        time.sleep(seconds)

    def put(self, cell: str, value: Any) -> None:
        if isinstance(value, str):
            self._cell(cell).String = value
        else:
            self._cell(cell).Value = value

    def style(self, cell: str) -> str:
        """Of a cell as conditions make it look: its background colour."""
        return f"{self._cell(cell).CellBackColor:06x}"

    def calculate(self) -> None:
        self.doc.calculateAll()

    def names(self) -> dict[str, str]:
        return {name.Name: name.Content for name in self.doc.NamedRanges}

    def links(self) -> list[list[Any]]:
        return [[link.Url, link.RefreshDelay] for link in self.doc.AreaLinks]

    def charts(self, sheet: str) -> int:
        return int(self.doc.Sheets.getByName(sheet).Charts.Count)

    def quit(self) -> None:
        self.close()
        self.desktop.terminate()

    def _cell(self, area: str) -> Any:
        sheet, _, cells = area.partition(".")
        return self.doc.Sheets.getByName(sheet).getCellRangeByName(cells)


def main() -> None:
    driver = Driver(connect(sys.argv[1]))
    print(json.dumps("ready"), flush=True)
    for line in sys.stdin:
        command, *arguments = json.loads(line)
        try:
            answer = getattr(driver, command)(*arguments)
        except Exception as error:
            answer = {"error": f"{type(error).__name__}: {getattr(error, 'Message', '') or error}"}
        print(json.dumps(answer), flush=True)
    # The tests are gone, however they ended: no office stays behind.
    with contextlib.suppress(Exception):
        driver.quit()


main()
