"""Choosing items on a terminal, line by line: search, numbers, done. Pure: lines in, lines out.

The lines work on every terminal and through a pipe; a full screen would not.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from fnmatch import translate
from typing import Final

from pcaccess.sheet.entries import Entry

SHOWN: Final = 30
"""Lines of a search that are shown; more scroll away."""
_NUMBERS: Final = re.compile(r"-?\d+(-\d+)?([ ,]+-?\d+(-\d+)?)*")


class Picker:
    """``chosen`` when ``done``."""

    def __init__(self, entries: Sequence[Entry]) -> None:
        self._entries = entries
        self._found: list[Entry] = list(entries)
        self.chosen: list[Entry] = []
        self.done = False

    def begin(self) -> list[str]:
        """What to show first."""
        return [
            "Formula wizard: a word or a pattern searches; 1 3 5-8 takes, -3 puts back; all takes what was found;",
            "list shows what is taken; an empty line is done; quit chooses nothing.",
            *self._listing(),
        ]

    def command(self, line: str) -> list[str]:
        """What a line does; lines to show."""
        words = line.strip()
        match words.lower():
            case "" | "done":
                self.done = True
                return []
            case "quit" | "exit":
                self.chosen, self.done = [], True
                return []
            case "all":
                self._take(self._found)
                return [self._count()]
            case "list":
                return [*(f"  {entry.item_id}" for entry in self.chosen), self._count()]
            case "?" | "help":
                return self.begin()[:2]
        if _NUMBERS.fullmatch(words):
            return self._numbers(words)
        self._search(words.casefold())
        return self._listing()

    def _search(self, words: str) -> None:
        if "*" in words or "?" in words:
            pattern = re.compile(translate(words.replace("[", "[[]")))
            self._found = [entry for entry in self._entries if pattern.match(entry.item_id.casefold())]
        else:
            self._found = [
                entry for entry in self._entries if words in f"{entry.item_id}\n{entry.description}".casefold()
            ]

    def _numbers(self, words: str) -> list[str]:
        for word in re.split(r"[ ,]+", words):
            back = word.startswith("-")
            low, _, high = word.lstrip("-").partition("-")
            first, last = int(low), int(high or low)
            if not 1 <= first <= last <= len(self._found):
                return [f"{word}: there are the numbers 1 to {len(self._found)}", self._count()]
            some = self._found[first - 1 : last]
            if back:
                self.chosen = [entry for entry in self.chosen if entry not in some]
            else:
                self._take(some)
        return [self._count()]

    def _take(self, some: Sequence[Entry]) -> None:
        self.chosen += [entry for entry in some if entry not in self.chosen]

    def _listing(self) -> list[str]:
        width = max((len(entry.item_id) for entry in self._found[:SHOWN]), default=0)
        lines = [
            f"{'*' if entry in self.chosen else ' '}{n:4}  {entry.item_id:{width}}  {entry.data_type.name:6} "
            f"{entry.description}".rstrip()
            for n, entry in enumerate(self._found[:SHOWN], start=1)
        ]
        more = len(self._found) - SHOWN
        if more > 0:
            lines.append(f"      and {more:,} more; search for fewer")
        return [*lines, self._count()] if lines else ["nothing is like that"]

    def _count(self) -> str:
        return f"{len(self.chosen)} taken"
