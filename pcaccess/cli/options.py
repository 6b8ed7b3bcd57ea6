"""Options that several commands share."""

from __future__ import annotations

import codecs
from enum import StrEnum
from typing import Annotated

import typer

from pcaccess.cli.endpoint import default_url
from pcaccess.project.durations import EXPECTED, DurationError, parse_duration
from pcaccess.project.network import NetworkError, check_endpoint, parse_web


class Execution(StrEnum):
    """How programs are executed; the results are the same."""

    AUTO = "auto"
    COMPILED = "compiled"
    INTERPRETER = "interpreter"


AsJson = Annotated[bool, typer.Option("--json", help="Print JSON, for programs.")]
MaxSize = Annotated[
    int | None, typer.Option("--max-size", min=1, metavar="MB", help="Accept project files of up to so many megabytes.")
]
Url = Annotated[
    str | None,
    typer.Option("--url", envvar="PCACCESS_URL", metavar="URL", help="The server. Default: that of ./items.yaml."),
]


def check_url(url: str) -> str:
    """An OPC UA endpoint; anything else is wrong usage."""
    try:
        check_endpoint(url)
    except NetworkError as error:
        raise typer.BadParameter(str(error)) from None
    return url


def check_listen(text: str) -> str:
    """HOST:PORT of the web server, or off; anything else is wrong usage."""
    try:
        parse_web(text)
    except NetworkError as error:
        raise typer.BadParameter(str(error)) from None
    return text


def server_url(url: str | None) -> str:
    """The server to talk to."""
    return check_url(default_url() if url is None else url)


def duration(text: str | None) -> float | None:
    """Seconds of an option such as ``250ms``; more than none."""
    if text is None:
        return None
    try:
        seconds = parse_duration(text)
    except DurationError as error:
        raise typer.BadParameter(f"{error}; expected {EXPECTED}") from None
    if seconds <= 0:
        raise typer.BadParameter(f"{text} is no time at all; expected {EXPECTED}")
    return seconds


def known_encoding(name: str | None) -> str | None:
    """An encoding that Python knows; anything else is wrong usage."""
    if name is not None:
        try:
            codecs.lookup(name)
            "a".encode(name)  # base64, for example, is one of Python's that is none of texts
        except (LookupError, UnicodeError):
            raise typer.BadParameter(
                f"there is no encoding {name!r}; usual ones are utf-8, cp1252, cp1251, gbk"
            ) from None
    return name
