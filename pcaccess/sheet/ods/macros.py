"""The Basic library ``Standard`` of a document: modules and the dialog, from the texts in ``pcaccess/sheet/basic``."""

from __future__ import annotations

from importlib.resources import files
from typing import Final

from pcaccess.sheet.ods.xml import HEAD, element, text

MODULES: Final = ("Collecting", "Writing", "Wizards", "Http")
DIALOG: Final = "Wizard"
_LIBRARY: Final = "http://openoffice.org/2000/library"
_SCRIPT: Final = "http://openoffice.org/2000/script"


def source(name: str) -> str:
    """The text of a file in ``pcaccess/sheet/basic``."""
    return (files("pcaccess.sheet") / "basic" / name).read_text(encoding="utf-8")


def macro(name: str) -> str:
    """How a button calls ``Module.Sub``."""
    return f"vnd.sun.star.script:Standard.{name}?language=Basic&location=document"


def macro_files() -> dict[str, str]:
    """Of the package, by path."""
    modules = {
        f"Basic/Standard/{name}.xml": _doctype("script:module", "module")
        + element(
            "script:module",
            {"xmlns:script": _SCRIPT, "script:name": name, "script:language": "StarBasic"},
            text(source(f"{name}.bas")),
        )
        for name in MODULES
    }
    return {
        "Basic/script-lc.xml": _libraries(),
        "Basic/Standard/script-lb.xml": _library(*MODULES),
        **modules,
        "Dialogs/dialog-lc.xml": _libraries(),
        "Dialogs/Standard/dialog-lb.xml": _library(DIALOG),
        f"Dialogs/Standard/{DIALOG}.xml": source(f"{DIALOG}.xdl"),
    }


def _libraries() -> str:
    return _doctype("library:libraries", "libraries") + element(
        "library:libraries",
        {"xmlns:library": _LIBRARY, "xmlns:xlink": "http://www.w3.org/1999/xlink"},
        element("library:library", {"library:name": "Standard", "library:link": "false"}),
    )


def _library(*names: str) -> str:
    return _doctype("library:library", "library") + element(
        "library:library",
        {
            "xmlns:library": _LIBRARY,
            "library:name": "Standard",
            "library:readonly": "false",
            "library:passwordprotected": "false",
        },
        *(element("library:element", {"library:name": name}) for name in names),
    )


def _doctype(root: str, name: str) -> str:
    return f'{HEAD}<!DOCTYPE {root} PUBLIC "-//OpenOffice.org//DTD OfficeDocument 1.0//EN" "{name}.dtd">\n'
