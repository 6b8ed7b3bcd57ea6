"""How cells look: the named styles of the document, which macros and conditions use too."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Final

from pcaccess.sheet.ods.xml import HEAD, element

FONT: Final = "Liberation Sans"
DARK: Final = "#1f4e5f"
LINE: Final = "0.05pt solid #d5dde1"

NAMESPACES: Final[Mapping[str, str]] = MappingProxyType(
    {
        f"xmlns:{prefix}": uri
        for prefix, uri in {
            "office": "urn:oasis:names:tc:opendocument:xmlns:office:1.0",
            "style": "urn:oasis:names:tc:opendocument:xmlns:style:1.0",
            "text": "urn:oasis:names:tc:opendocument:xmlns:text:1.0",
            "table": "urn:oasis:names:tc:opendocument:xmlns:table:1.0",
            "draw": "urn:oasis:names:tc:opendocument:xmlns:drawing:1.0",
            "fo": "urn:oasis:names:tc:opendocument:xmlns:xsl-fo-compatible:1.0",
            "xlink": "http://www.w3.org/1999/xlink",
            "number": "urn:oasis:names:tc:opendocument:xmlns:datastyle:1.0",
            "svg": "urn:oasis:names:tc:opendocument:xmlns:svg-compatible:1.0",
            "chart": "urn:oasis:names:tc:opendocument:xmlns:chart:1.0",
            "form": "urn:oasis:names:tc:opendocument:xmlns:form:1.0",
            "script": "urn:oasis:names:tc:opendocument:xmlns:script:1.0",
            "config": "urn:oasis:names:tc:opendocument:xmlns:config:1.0",
            "meta": "urn:oasis:names:tc:opendocument:xmlns:meta:1.0",
            "dc": "http://purl.org/dc/elements/1.1/",
            "of": "urn:oasis:names:tc:opendocument:xmlns:of:1.2",
            "ooo": "http://openoffice.org/2004/office",
            "calcext": "urn:org:documentfoundation:names:experimental:calc:xmlns:calcext:1.0",
            "loext": "urn:org:documentfoundation:names:experimental:office:xmlns:loext:1.0",
        }.items()
    }
)
VERSION: Final = {"office:version": "1.3"}


@dataclass(frozen=True, slots=True)
class CellStyle:
    """``cell``, ``paragraph`` and ``text`` are properties of ODF; ``number`` names a number format."""

    cell: Mapping[str, str] = field(default_factory=dict)
    paragraph: Mapping[str, str] = field(default_factory=dict)
    text: Mapping[str, str] = field(default_factory=dict)
    number: str | None = None


_BOLD: Final = {"fo:font-weight": "bold"}
_MIDDLE: Final = {"style:vertical-align": "middle", "fo:padding": "0.06cm"}
_UNDERLINED: Final = {**_MIDDLE, "fo:border-bottom": LINE}

STYLES: Final[Mapping[str, CellStyle]] = MappingProxyType(
    {
        "Default": CellStyle(_MIDDLE, {}, {"style:font-name": FONT, "fo:font-size": "10pt", "fo:color": "#222222"}),
        "Title": CellStyle(_MIDDLE, {}, {**_BOLD, "fo:font-size": "16pt", "fo:color": DARK}),
        "Note": CellStyle(_MIDDLE, {}, {"fo:color": "#5b6b73"}),
        "Title row": CellStyle(
            {**_MIDDLE, "fo:background-color": DARK, "fo:wrap-option": "wrap"}, {}, {**_BOLD, "fo:color": "#ffffff"}
        ),
        "Title row right": CellStyle(
            {**_MIDDLE, "fo:background-color": DARK, "fo:wrap-option": "wrap", "style:text-align-source": "fix"},
            {"fo:text-align": "end"},
            {**_BOLD, "fo:color": "#ffffff"},
        ),
        "Text": CellStyle(_UNDERLINED),
        "Value": CellStyle(
            {**_UNDERLINED, "style:text-align-source": "fix"}, {"fo:text-align": "end"}, {**_BOLD}, number="General"
        ),
        **{
            f"Value {digits}": CellStyle(
                {**_UNDERLINED, "style:text-align-source": "fix"},
                {"fo:text-align": "end"},
                {**_BOLD},
                f"Digits{digits}",
            )
            for digits in range(7)
        },
        "Code": CellStyle({**_UNDERLINED, "style:text-align-source": "fix"}, {"fo:text-align": "center"}),
        "Time stamp": CellStyle(
            {**_UNDERLINED, "style:text-align-source": "fix"}, {"fo:text-align": "start"}, {}, "Time"
        ),
        "Clock": CellStyle({**_UNDERLINED, "style:text-align-source": "fix"}, {"fo:text-align": "start"}, {}, "Clock"),
        "Write cell": CellStyle(
            {
                **_MIDDLE,
                "fo:background-color": "#fff6cc",
                "fo:border": "0.75pt solid #d9b93b",
                "style:text-align-source": "fix",
            },
            {"fo:text-align": "end"},
            {**_BOLD},
        ),
        "Setting": CellStyle(
            {
                **_MIDDLE,
                "fo:background-color": "#fff6cc",
                "fo:border": "0.75pt solid #d9b93b",
                "style:text-align-source": "fix",
            },
            {"fo:text-align": "start"},
            {},
        ),
        "Left": CellStyle({**_UNDERLINED, "style:text-align-source": "fix"}, {"fo:text-align": "start"}, {}),
        "Good": CellStyle({"fo:background-color": "#dff3e4"}, {}, {"fo:color": "#1b6e3c"}),
        "Uncertain": CellStyle({"fo:background-color": "#fff0c2"}, {}, {"fo:color": "#7a5600"}),
        "Bad": CellStyle({"fo:background-color": "#f9d6d9"}, {}, {**_BOLD, "fo:color": "#a01522"}),
        "Faint": CellStyle({}, {}, {"fo:color": "#c3ccd1"}),
    }
)


def style_name(display: str) -> str:
    """A display name as the name in the file."""
    return display.replace(" ", "_20_")


def styles_xml() -> str:
    """``styles.xml`` of the document."""
    return HEAD + element(
        "office:document-styles",
        {**NAMESPACES, **VERSION},
        element(
            "office:font-face-decls",
            None,
            element(
                "style:font-face", {"style:name": FONT, "svg:font-family": f"'{FONT}'", "style:font-pitch": "variable"}
            ),
        ),
        element("office:styles", None, *_numbers(), *(_style(name, style) for name, style in STYLES.items())),
        element("office:automatic-styles", None, _page()),
        element(
            "office:master-styles",
            None,
            element("style:master-page", {"style:name": "Default", "style:page-layout-name": "page"}),
        ),
    )


def _style(name: str, style: CellStyle) -> str:
    base = name == "Default"
    return element(
        "style:style",
        {
            "style:name": style_name(name),
            "style:display-name": name if " " in name else None,
            "style:family": "table-cell",
            "style:parent-style-name": None if base else "Default",
            "style:data-style-name": style.number,
        },
        element("style:table-cell-properties", style.cell) if style.cell else "",
        element("style:paragraph-properties", style.paragraph) if style.paragraph else "",
        element("style:text-properties", style.text) if style.text else "",
    )


Part = str | tuple[str, dict[str, str]]


def _numbers() -> list[str]:
    long = {"number:style": "long"}
    date: list[Part] = [("year", long), "-", ("month", long), "-", ("day", long)]
    clock: list[Part] = [("hours", long), ":", ("minutes", long), ":", ("seconds", long)]
    return [
        element(
            "number:number-style", {"style:name": "General"}, element("number:number", {"number:min-integer-digits": 1})
        ),
        *(
            element(
                "number:number-style",
                {"style:name": f"Digits{digits}"},
                element(
                    "number:number",
                    {
                        "number:decimal-places": digits,
                        "number:min-decimal-places": digits,
                        "number:min-integer-digits": 1,
                    },
                ),
            )
            for digits in range(7)
        ),
        element("number:date-style", {"style:name": "Time"}, *_parts([*date, " ", *clock])),
        element("number:time-style", {"style:name": "Clock"}, *_parts(clock)),
    ]


def _parts(parts: list[Part]) -> list[str]:
    return [
        element("number:text", None, part) if isinstance(part, str) else element(f"number:{part[0]}", part[1])
        for part in parts
    ]


def _page() -> str:
    """Landscape, as wide as one page, so that a book prints well."""
    return element(
        "style:page-layout",
        {"style:name": "page"},
        element(
            "style:page-layout-properties",
            {
                "fo:page-width": "29.7cm",
                "fo:page-height": "21cm",
                "style:print-orientation": "landscape",
                "fo:margin": "1.2cm",
                "style:scale-to-X": 1,
                "style:scale-to-Y": 0,
            },
        ),
    )
