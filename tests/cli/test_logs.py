"""The log of a server whose standard error nobody reads."""

from __future__ import annotations

import io
import logging
import os
from collections.abc import Iterator

import pytest

from pcaccess.cli.logs import LogWriter


@pytest.fixture
def pipe() -> Iterator[tuple[int, io.TextIOWrapper]]:
    """A pipe's end to read from, and a text stream into it."""
    out, into = os.pipe()
    stream = open(into, "w", encoding="utf-8")  # noqa: SIM115
    yield out, stream
    os.close(out)
    stream.close()


def logger_of(handler: logging.Handler) -> logging.Logger:
    logger = logging.Logger("plant")
    logger.addHandler(handler)
    return logger


def read(out: int) -> str:
    """What was written so far; at least one message."""
    return os.read(out, 1 << 20).decode()


def test_messages_come_in_order_and_the_last_ones_before_the_end(pipe: tuple[int, io.TextIOWrapper]) -> None:
    out, stream = pipe
    writer = LogWriter(stream)
    for n in range(100):
        logger_of(writer).warning("tank %d is full: °C", n)
    writer.close()
    lines = read(out).splitlines()
    assert [line.split(" ", 2)[2] for line in lines] == [f"WARNING plant: tank {n} is full: °C" for n in range(100)]


def test_a_reader_who_takes_nothing_holds_nobody_and_learns_how_much_was_lost(
    pipe: tuple[int, io.TextIOWrapper],
) -> None:
    out, stream = pipe
    writer = LogWriter(stream, waiting=10)
    logger = logger_of(writer)
    for n in range(2000):  # 200 kB, more than a pipe and the queue hold
        logger.error("%03d %s", n, "x" * 100)
    said = ""
    while "were lost" not in said:
        said += read(out)
    lost = int(next(line for line in said.splitlines() if "were lost" in line).split()[0])
    written = said.count("ERROR plant")
    assert lost > 0
    assert written + lost <= 2000
    writer.close()


def test_the_end_does_not_wait_for_a_reader_who_takes_nothing(pipe: tuple[int, io.TextIOWrapper]) -> None:
    _, stream = pipe
    writer = LogWriter(stream, waiting=10)
    for _ in range(2000):
        logger_of(writer).error("x" * 100)
    writer.close()  # a test that hangs has failed


def test_a_stream_that_does_not_wait_is_not_asked_again_and_again(pipe: tuple[int, io.TextIOWrapper]) -> None:
    out, stream = pipe
    os.set_blocking(stream.fileno(), False)
    writer = LogWriter(stream)
    for n in range(900):  # 90 kB, more than a pipe holds
        logger_of(writer).error("%03d %s", n, "x" * 100)
    writer.close()
    assert not writer._thread.is_alive()  # though nobody read
    assert "ERROR plant: 000" in read(out)


def test_a_stream_without_a_reader_is_no_trouble(pipe: tuple[int, io.TextIOWrapper]) -> None:
    out, into = os.pipe()
    os.close(out)
    stream = open(into, "w", encoding="utf-8")  # noqa: SIM115
    writer = LogWriter(stream)
    logger_of(writer).error("nobody reads this")
    writer.close()
    stream.close()


def test_a_stream_that_is_no_file_is_written_to() -> None:
    stream = io.StringIO()
    writer = LogWriter(stream)
    logger_of(writer).error("hello")
    writer.close()
    assert stream.getvalue().endswith("ERROR plant: hello\n")
