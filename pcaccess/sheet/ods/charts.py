"""A line chart over columns of a sheet, as a document inside the document.

Source:   OpenDocument 1.3 part 3, chapter 11.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from pcaccess.sheet.ods.styles import NAMESPACES, VERSION
from pcaccess.sheet.ods.xml import HEAD, element

COLOURS: Final = ("#1f77b4", "#d95f02", "#2e8b57", "#b8336a", "#6a51a3", "#8c6d1f", "#17a2b8", "#555555")


@dataclass(frozen=True, slots=True)
class LineChart:
    """``times`` is the range of the x axis, ``lines`` are ``(title cell, range)``; width and height in cm."""

    times: str
    lines: Sequence[tuple[str, str]]
    width: float
    height: float

    @property
    def ranges(self) -> list[str]:
        """Everything that it shows."""
        return [self.times, *(place for line in self.lines for place in line)]


def chart_xml(chart: LineChart) -> str:
    """``content.xml`` of the chart."""
    styles = [
        _style("chart", element("style:graphic-properties", {"draw:stroke": "none", "draw:fill-color": "#ffffff"})),
        _style(
            "plot",
            element(
                "style:chart-properties",
                {"chart:auto-position": "true", "chart:auto-size": "true", "chart:treat-empty-cells": "leave-gap"},
            ),
        ),
        _style("wall", element("style:graphic-properties", {"draw:fill": "none", "draw:stroke": "none"})),
        _style("legend", element("style:graphic-properties", {"draw:stroke": "none"}) + _small()),
        _style("axis", _axis(rotated=False) + _grey("#9aa7ad") + _small()),
        _style("times", _axis(rotated=True) + _grey("#9aa7ad") + _small()),
        _style("grid", _grey("#e3e8eb")),
        *(
            _style(
                f"line{n}",
                element(
                    "style:chart-properties", {"chart:symbol-type": "none", "chart:link-data-style-to-source": "true"}
                )
                + element(
                    "style:graphic-properties", {"svg:stroke-width": "0.06cm", "svg:stroke-color": COLOURS[n % 8]}
                ),
            )
            for n in range(len(chart.lines))
        ),
    ]
    plot = element(
        "chart:plot-area",
        {"chart:style-name": "plot", "chart:data-source-has-labels": "both"},
        element(
            "chart:axis",
            {"chart:dimension": "x", "chart:name": "primary-x", "chart:style-name": "times"},
            element("chart:categories", {"table:cell-range-address": chart.times}),
        ),
        element(
            "chart:axis",
            {"chart:dimension": "y", "chart:name": "primary-y", "chart:style-name": "axis"},
            element("chart:grid", {"chart:style-name": "grid", "chart:class": "major"}),
        ),
        *(
            element(
                "chart:series",
                {
                    "chart:style-name": f"line{n}",
                    "chart:values-cell-range-address": values,
                    "chart:label-cell-address": title,
                    "chart:class": "chart:line",
                },
            )
            for n, (title, values) in enumerate(chart.lines)
        ),
        element("chart:wall", {"chart:style-name": "wall"}),
    )
    body = element(
        "chart:chart",
        {
            "svg:width": f"{chart.width}cm",
            "svg:height": f"{chart.height}cm",
            "xlink:href": "..",
            "xlink:type": "simple",
            "chart:class": "chart:line",
            "chart:style-name": "chart",
        },
        element("chart:legend", {"chart:legend-position": "bottom", "chart:style-name": "legend"}),
        plot,
    )
    return HEAD + element(
        "office:document-content",
        {**NAMESPACES, **VERSION},
        element("office:automatic-styles", None, *styles),
        element("office:body", None, element("office:chart", None, body)),
    )


def _style(name: str, properties: str) -> str:
    return element("style:style", {"style:name": name, "style:family": "chart"}, properties)


def _axis(*, rotated: bool) -> str:
    return element(
        "style:chart-properties",
        {
            "chart:display-label": "true",
            "chart:link-data-style-to-source": "true",
            "text:line-break": "false",
            "style:rotation-angle": 45 if rotated else None,
        },
    )


def _grey(colour: str) -> str:
    return element("style:graphic-properties", {"svg:stroke-color": colour})


def _small() -> str:
    return element("style:text-properties", {"fo:font-size": "9pt"})
