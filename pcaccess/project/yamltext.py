"""YAML text to nodes that know where they stand.

The events of libyaml's parser are put together here and not by PyYAML's composer, for three reasons: the
composer recurses in C and ends the process on deep nesting, it cannot tell a written tag from a guessed one,
and it guesses (``Off`` becomes false, ``010`` eight). Here every scalar is the text that stands in the file; what
it means is the business of the key it belongs to. No tag is accepted, so nothing a file says can run.

Units:    lines and columns count characters from 1.
Errors:   :class:`YamlError` where reading has to stop; what can be stepped over is a :class:`Fault` of the tree.
Not here: which keys there are (``pcaccess.project.raw``).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Final

import yaml

try:
    from yaml import CSafeLoader as _Loader
except ImportError:  # a PyYAML built without libyaml: slower, the same events
    from yaml import SafeLoader as _Loader  # type: ignore[assignment]

from pcaccess.problems import Span

MAX_DEPTH: Final = 100
"""Levels of nesting. A project needs ten and its folders a few more."""
MAX_EXPANSION: Final = 1_000_000
"""Nodes that aliases may add to what stands in the text."""

_NULL: Final = frozenset({"", "~", "null", "Null", "NULL"})


@dataclass(frozen=True, slots=True)
class Fault:
    """Something wrong; ``code`` is a key of the project register."""

    code: str
    span: Span
    message: str
    related: tuple[tuple[Span, str], ...] = ()


class YamlError(Exception):
    """Nothing behind this place can be read; ``faults`` has it and what was found before."""

    def __init__(self, *faults: Fault) -> None:
        super().__init__("; ".join(fault.message for fault in faults))
        self.faults = faults


@dataclass(slots=True)
class Scalar:
    """A text; None where the file says nothing or ``null``."""

    text: str | None
    line: int
    column: int
    length: int
    quoted: bool = False

    size = 1


@dataclass(slots=True)
class Sequence:
    line: int
    column: int
    children: list[Node] = field(default_factory=list)
    size: int = 1
    """Nodes below and including this one, aliases written out."""


@dataclass(slots=True)
class Mapping:
    line: int
    column: int
    pairs: dict[str, tuple[Scalar, Node]] = field(default_factory=dict)
    """Key to the key's own place and the value."""
    size: int = 1

    def get(self, key: str) -> Node | None:
        pair = self.pairs.get(key)
        return pair[1] if pair else None


Node = Scalar | Sequence | Mapping


class Tree:
    """The nodes of one file, and the spans of places in it."""

    def __init__(self, file: str, root: Node, faults: tuple[Fault, ...] = ()) -> None:
        self.file = file
        self.root = root
        self.faults = faults

    def span(self, node: Node) -> Span:
        """Of a scalar the whole of it, of a mapping its first key, of a sequence its first character."""
        if isinstance(node, Scalar):
            return Span(self.file, node.line, node.column, node.length)
        if isinstance(node, Mapping):
            for key, _ in node.pairs.values():
                return Span(self.file, key.line, key.column, key.length)
        return Span(self.file, node.line, node.column, 1)

    def value_span(self, node: Node, key: str) -> Span:
        """Where the value of ``key`` stands: the key itself if it has none, the mapping if there is no such key."""
        if not isinstance(node, Mapping) or key not in node.pairs:
            return self.span(node)
        at, value = node.pairs[key]
        return self.span(at if isinstance(value, Scalar) and value.text is None else value)

    def key_span(self, node: Node, key: str) -> Span:
        if not isinstance(node, Mapping) or key not in node.pairs:
            return self.span(node)
        return self.span(node.pairs[key][0])


def plain(node: Node) -> Any:
    """Dictionaries, lists, texts and None, for pydantic."""
    if isinstance(node, Scalar):
        return node.text
    if isinstance(node, Mapping):
        return {key: plain(value) for key, (_, value) in node.pairs.items()}
    return [plain(child) for child in node.children]


def read_yaml(text: str, file: str) -> Tree:
    """Raises YamlError where nothing further can be trusted: no YAML, an empty file, a tag, a bomb of aliases."""
    reader = _Reader(file, len(text))
    try:
        root = reader.read(yaml.parse(text, Loader=_Loader))
    except (yaml.reader.ReaderError, UnicodeEncodeError) as error:
        at = error.position if isinstance(error, yaml.reader.ReaderError) else error.start
        before = text[:at]
        span = Span(file, before.count("\n") + 1, len(before) - before.rfind("\n"))
        raise YamlError(*reader.faults, Fault("PRJ002", span, f"the character {text[at : at + 1]!a}")) from None
    except yaml.MarkedYAMLError as error:
        raise YamlError(*reader.faults, _syntax_fault(error, text, file)) from None
    if any(fault.code == "PRJ004" for fault in reader.faults):
        raise YamlError(*reader.faults)
    if root is None or (isinstance(root, Scalar) and root.text is None):
        raise YamlError(Fault("PRJ007", Span(file, 1, 1), "the file is empty"))
    return Tree(file, root, tuple(reader.faults))


class _Reader:
    def __init__(self, file: str, characters: int) -> None:
        self._file = file
        self._limit = characters + MAX_EXPANSION
        self._anchors: dict[str, Node | None] = {}  # None: not complete yet
        self._open: list[tuple[Sequence | Mapping, str | None]] = []
        self._key: list[Scalar | None] = []  # of each open mapping, the key that waits for its value
        self._root: Node | None = None
        self.faults: list[Fault] = []

    def read(self, events: Iterator[Any]) -> Node | None:
        for event in events:
            if isinstance(event, yaml.ScalarEvent):
                self._check(event)
                node = self._scalar(event)
                if event.anchor:
                    self._anchors[event.anchor] = node
                self._put(node)
            elif isinstance(event, yaml.MappingStartEvent):
                self._start(Mapping(*_place(event)), event)
                self._key.append(None)
            elif isinstance(event, yaml.SequenceStartEvent):
                self._start(Sequence(*_place(event)), event)
            elif isinstance(event, yaml.CollectionEndEvent):
                self._end()
            elif isinstance(event, yaml.AliasEvent):
                self._put(self._resolve(event))
            elif isinstance(event, yaml.DocumentStartEvent) and self._root is not None:
                raise self._stop("PRJ002", self._at(event), "a second YAML document; a project file is one document")
        return self._root

    def _stop(self, code: str, span: Span, message: str) -> YamlError:
        return YamlError(*self.faults, Fault(code, span, message))

    def _at(self, event: Any, length: int = 1) -> Span:
        return Span(self._file, *_place(event), length)

    def _check(self, event: Any) -> None:
        if event.tag not in (None, "!"):
            name = event.tag.replace("tag:yaml.org,2002:", "!!")
            self.faults.append(Fault("PRJ004", self._at(event, len(name)), f"the tag {name}; {_NO_TAGS}"))
        if len(self._open) >= MAX_DEPTH:
            raise self._stop("PRJ002", self._at(event), f"nested more than {MAX_DEPTH} levels deep")

    def _scalar(self, event: Any) -> Scalar:
        start, end = event.start_mark, event.end_mark
        text = None if not event.style and event.value in _NULL else event.value
        length = end.column - start.column if end.line == start.line else 1
        return Scalar(text, start.line + 1, start.column + 1, max(1, length), event.style in ('"', "'"))

    def _start(self, node: Sequence | Mapping, event: Any) -> None:
        self._check(event)
        if event.anchor:
            self._anchors[event.anchor] = None
        self._open.append((node, event.anchor))

    def _end(self) -> None:
        node, anchor = self._open.pop()
        if isinstance(node, Mapping):
            self._key.pop()
            self._merge(node)
        if anchor:
            self._anchors[anchor] = node
        self._put(node)

    def _resolve(self, event: Any) -> Node:
        span = self._at(event, len(event.anchor) + 1)
        if event.anchor not in self._anchors:
            raise self._stop("PRJ002", span, f"*{event.anchor} refers to nothing; no &{event.anchor} stands above it")
        node = self._anchors[event.anchor]
        if node is None:
            raise self._stop("PRJ005", span, f"*{event.anchor} contains itself")
        if sum(parent.size for parent, _ in self._open) + node.size > self._limit:
            raise self._stop("PRJ005", span, f"*{event.anchor} makes the file more than {self._limit} values long")
        return node

    def _put(self, node: Node) -> None:
        """Hand a complete node to what it stands in."""
        if not self._open:
            self._root = node
            return
        parent = self._open[-1][0]
        if isinstance(parent, Sequence):
            parent.children.append(node)
            parent.size += node.size
            return
        key = self._key[-1]
        if key is None:
            self._key[-1] = self._as_key(node, parent)
            return
        assert key.text is not None
        parent.pairs.setdefault(key.text, (key, node))
        parent.size += node.size
        self._key[-1] = None

    def _as_key(self, node: Node, parent: Mapping) -> Scalar:
        if not isinstance(node, Scalar) or node.text is None:
            raise self._stop("PRJ002", Span(self._file, node.line, node.column), "a key must be a word")
        if node.text in parent.pairs:
            first = parent.pairs[node.text][0]
            first_span = Span(self._file, first.line, first.column, first.length)
            span = Span(self._file, node.line, node.column, node.length)
            related = ((first_span, "first used here"),)
            self.faults.append(Fault("PRJ006", span, f"the key {node.text!r} stands here twice", related))
        return node

    def _merge(self, node: Mapping) -> None:
        """``<<: *defaults``: keys of another mapping, where this one does not have them."""
        if "<<" not in node.pairs:
            return
        at, value = node.pairs.pop("<<")
        sources = value.children if isinstance(value, Sequence) else [value]
        for source in sources:
            if not isinstance(source, Mapping):
                span = Span(self._file, at.line, at.column, at.length)
                raise self._stop("PRJ002", span, "<< takes a mapping, for example <<: *defaults")
            for key, pair in source.pairs.items():
                node.pairs.setdefault(key, pair)


def _place(event: Any) -> tuple[int, int]:
    return event.start_mark.line + 1, event.start_mark.column + 1


_NO_TABS: Final = "a tab in the indentation; indent with blanks"
_NO_TAGS: Final = "a project file obeys none; a text that begins with ! must stand in quotes"
_IN_OTHER_WORDS: Final = {
    "mapping values are not allowed in this context": "a ': ' where no key can stand; quote the text that holds it, "
    "or look at the indentation",
    "found unexpected end of stream": "a quotation mark that is never closed",
    "did not find expected ',' or '}'": "a ',' or '}' is missing before this",
    "did not find expected ',' or ']'": "a ',' or ']' is missing before this",
    "did not find expected '-' indicator": "this does not line up with the list above",
    "did not find expected key": "this does not line up with the keys above",
    "did not find expected <document start>": "this does not line up with the keys above",
    "could not find expected ':'": "a ':' is missing after the key above",
    "found character that cannot start any token": "a text that begins with @, ` or % must stand in quotes",
    "found unknown escape character": "a backslash means something in double quotes; use single quotes",
    "found a tab character that violates indentation": _NO_TABS,
}


def _syntax_fault(error: yaml.MarkedYAMLError, text: str, file: str) -> Fault:
    mark = error.problem_mark or error.context_mark
    line, column = (mark.line, mark.column) if mark else (0, 0)
    lines = text.splitlines()
    for number in range(min(line, len(lines) - 1), max(-1, line - 3), -1):
        indentation = lines[number][: len(lines[number]) - len(lines[number].lstrip())]
        if "\t" in indentation:
            return Fault("PRJ003", Span(file, number + 1, indentation.index("\t") + 1), _NO_TABS)
    said = error.problem or error.context or "something is wrong here"
    related: tuple[tuple[Span, str], ...] = ()
    if error.context and error.context_mark and error.context_mark.line != line:
        start = error.context_mark
        related = ((Span(file, start.line + 1, start.column + 1), error.context),)
    return Fault("PRJ002", Span(file, line + 1, column + 1), _IN_OTHER_WORDS.get(said, said), related)
