"""The lines of a program sorted into blocks, networks and statements; no operand is understood yet.

Two kinds of files: exports with block headers (``SUBROUTINE_BLOCK Pump:SBR0`` … ``END_SUBROUTINE_BLOCK``), and
programs as printed in books, which have none: everything is the main program, ``MEND`` ends it, ``SBR 0`` …
``RET`` and ``INT 0`` … ``RETI`` (or a comment that says as much above a ``NETWORK 1``) start further blocks.

Source:   Micro/WIN export format (docs/stl.md); document 004, section 9.26, for SBR … RET and INT … RETI.
Errors:   collected; nothing raises.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Sequence
from typing import Final

from pcaccess.problems import Span
from pcaccess.stl.headers import (
    KEYWORDS,
    OLD_ENDS,
    SECTIONS,
    NetworkHeader,
    find_headers,
    header_text,
    is_header,
    keyword_of,
    parse_comment_start,
    parse_directive,
    parse_header,
    parse_network,
    parse_old_start,
)
from pcaccess.stl.lexer import comment_text, first_word, split_code
from pcaccess.stl.problems import Collector
from pcaccess.stl.program import PouKind, Section
from pcaccess.stl.rawblocks import RawBlock, RawFile, RawNetwork
from pcaccess.stl.statements import StatementReader, shortened

MAX_LINE: Final = 4000
"""Characters; no line of a program is longer."""
_TITLE: Final = re.compile(r"\s*TITLE\s*=(?P<title>.*)", re.IGNORECASE)
_LOOK_AHEAD: Final = 40


def read_blocks(lines: Sequence[str], problems: Collector, known: Collection[str]) -> RawFile:
    """``known``: all mnemonics, needed to tell an instruction from other words where a line can be both."""
    reader = _BlockReader(lines, problems, known)
    reader.read()
    return reader.file


class _BlockReader:
    def __init__(self, lines: Sequence[str], problems: Collector, known: Collection[str]) -> None:
        self.lines = lines
        self.problems = problems
        self.known = known
        self.statements = StatementReader(problems, known)
        self.file = RawFile()
        headers, self.heads = find_headers(lines)
        """``heads``: numbers of the block headers that have their BEGIN."""
        self.explicit = headers > 0
        """The file has block headers, so text outside of blocks is a mistake."""
        self.block: RawBlock | None = None
        self.network: RawNetwork | None = None
        self.pending: list[str] = []
        self.section: Section | None = None
        self.section_line = 0
        self.in_head = False
        """Between a block header and BEGIN, where plain text is comment."""
        self.directive: str | None = None
        self.nameless = 0
        """Headers so far that do not say their block's number."""
        self.astray = False
        """The line before was already reported as standing outside of every block."""
        self.handlers: dict[str, Callable[[int, str], None]] = {
            "TITLE": self.read_title,
            "BEGIN": self.read_begin,
            **dict.fromkeys(SECTIONS, self.read_section),
            "END_VAR": self.read_end_var,
            **dict.fromkeys(OLD_ENDS, self.read_old_end),
            "SBR": self.read_old_start,
            "INT": self.read_old_start,
        }

    def read(self) -> None:
        for number, line in enumerate(self.lines, 1):
            stripped = line.strip()
            if not stripped:
                continue
            if stripped.startswith("//"):
                self.read_comment(number, line, stripped)
                continue
            self.directive = None
            if len(line) > MAX_LINE:
                self.statements.refuse(number, line)
            else:
                self.read_code(number, line)
        self.finish()

    # -- comments and what hides in them

    def read_comment(self, number: int, line: str, stripped: str) -> None:
        if self.directive or self.block is None or not self.explicit:
            mark = parse_directive(line)
            if mark is not None:
                self.directive = None if mark[1] else mark[0]
                return
        if self.directive is not None:
            target = {"SYMBOL_TABLE": self.file.symbols, "DATA_BLOCK": self.file.data}.get(self.directive)
            if target is not None:
                cut = line.index("//") + 2
                target.append((number, cut, line[cut:]))
            return
        if not self.explicit and self.starts_block(number, line):
            return
        text = comment_text(stripped)
        if self.block is None:
            if not self.explicit:
                self.pending.append(text)
        elif self.network is None:
            self.block.comment.append(text)
        elif self.network.statements:
            self.pending.append(text)
        else:
            self.network.comment.append(text)

    def starts_block(self, number: int, line: str) -> bool:
        awaited = self.statements.called - {(block.kind, block.number) for block in self.file.blocks}
        start = parse_comment_start(line, self.lines[number : number + _LOOK_AHEAD], awaited)
        if start is None or (start[0] is PouKind.MAIN and self.block is None):
            return False
        kind, index = start
        span = self.problems.span(number, line.index("//") + 1, len(line.strip()))
        name = "MAIN" if kind is PouKind.MAIN else f"{kind.value}_{index}"
        expected = f"the header {header_text(kind, index, name)}"
        self.problems.add("STL010", span, f"read as the start of {kind.value}{index}", expected=expected, where="")
        self.open(RawBlock(kind, index, name, span, comment=[comment_text(line.strip())]))
        return True

    # -- code

    def read_code(self, number: int, line: str) -> None:
        if self.section is not None and self.read_declaration(number, line):
            return
        word = first_word(line)
        upper = word.upper()
        if upper.startswith("NETWORK"):
            network = parse_network(line)
            if network is not None:
                self.read_network(number, line, network)
                return
        if upper.endswith("_BLOCK"):
            if upper.startswith("END_"):
                self.read_block_end(number, line, upper)
            else:
                self.read_header(number, line, upper)
            return
        if ":" in line and upper not in self.known and is_header(split_code(line)[0]):
            self.read_header(number, line, upper)
            return
        handler = self.handlers.get(upper)
        if handler is not None:
            handler(number, line)
        elif self.block is not None and self.in_head:
            self.block.comment.append(line.strip())
        elif self.block is not None and self.block.keyword and upper == f"END_{self.block.keyword}":
            self.close()  # a header in another language
        else:
            self.read_statement(number, line)

    def read_header(self, number: int, line: str, keyword: str) -> None:
        code = split_code(line)[0]
        span = self.span(number, code)
        header = parse_header(code, keyword)
        if header.right is not None:
            self.wrong_header(span, keyword, code, header.right)
        index = header.number
        if index is None:
            index = 1 if header.kind is PouKind.MAIN else self.nameless
            self.nameless += header.kind is not PouKind.MAIN
        if self.block is not None and self.block.keyword:
            opened = ((self.block.span, "it begins here"),)
            expected = f"END_{self.block.keyword} before the next block"
            self.problems.add("STL004", span, f"{self.block.name} is not closed", expected=expected, related=opened)
        self.section = None
        self.open(RawBlock(header.kind, index, header.name or f"{header.kind.value}{index}", span, keyword))
        self.in_head = number in self.heads

    def wrong_header(self, span: Span, keyword: str, code: str, right: str) -> None:
        expected = right or f"{' or '.join(KEYWORDS)}, a name, and :OB1, :SBR0 to :SBR127 or :INT0 to :INT127"
        nearest = self.problems.nearest(keyword, KEYWORDS) if keyword not in KEYWORDS else None
        message = f"{shortened(code)} is not the header of a block"
        if keyword == "FUNCTION_BLOCK":
            message += "; only the S7-200 SMART and the S7-300 have function blocks"
        self.problems.add("STL005", span, message, expected=expected, nearest=nearest, where="")

    def read_block_end(self, number: int, line: str, keyword: str) -> None:
        if self.block is None:
            self.outside(number, line)
            return
        if self.block.keyword and keyword != f"END_{self.block.keyword}":
            span = self.problems.span(number, line.upper().index(keyword) + 1, len(keyword))
            opened = ((self.block.span, "the block that is open begins here"),)
            message = f"{keyword} does not close {self.block.name}"
            self.problems.add("STL004", span, message, expected=f"END_{self.block.keyword}", related=opened)
        self.close()

    def read_title(self, number: int, line: str) -> None:
        match = _TITLE.fullmatch(line)
        if match is None:
            self.read_statement(number, line)
            return
        block = self.need_block(number, line)
        if block is not None and self.network is None:
            block.title = match["title"].strip()

    def read_begin(self, number: int, line: str) -> None:
        self.need_block(number, line)
        self.in_head = False

    def read_section(self, number: int, line: str) -> None:
        if self.need_block(number, line) is not None:
            self.section = SECTIONS[first_word(line).upper()]
            self.section_line = number

    def read_declaration(self, number: int, line: str) -> bool:
        """True when the line belongs to the open VAR section."""
        word = first_word(line).upper()
        if word == "END_VAR":
            self.section = None
            return True
        ends = word.endswith("_BLOCK") or word in ("BEGIN", *SECTIONS) or parse_network(line) is not None
        if ends:
            span = self.span(self.section_line, self.lines[self.section_line - 1])
            message = "the variable section is not closed"
            self.problems.add("STL004", span, message, expected="END_VAR before the next part")
            self.section = None
            return False
        if self.block is not None and self.section is not None:
            self.block.declarations.append((self.section, number, line))
        return True

    def read_end_var(self, number: int, line: str) -> None:
        self.outside(number, line, "END_VAR closes no variable section")

    def read_network(self, number: int, line: str, header: NetworkHeader) -> None:
        block = self.need_block(number, line)
        if block is None:
            return
        self.end_network()
        self.in_head = False
        before = block.networks[-1].number if block.networks else 0
        index = before + 1 if header.number is None else header.number
        span = self.problems.span(number, header.column, header.length)
        self.enter(RawNetwork(index, "", span), block)
        title = header.rest
        if title.startswith("//"):
            title = comment_text(title)
        elif title.strip(" ;"):
            at = self.problems.span(number, header.rest_column, len(title))
            self.problems.add("STL008", at, "text behind the network's number", expected="// before the title")
        if index <= before:
            message = f"network {index} comes after network {before}"
            expected = "numbers that go up; where they start again, a block header is missing"
            self.problems.add("STL009", span, message, expected=expected)
        if self.network is not None:
            self.network.title = title.strip(" ;") if not header.rest.startswith("//") else title
            self.network.comment, self.pending = self.pending, []

    def read_old_end(self, number: int, line: str) -> None:
        word = first_word(line).upper()
        block = self.need_block(number, line) if word == "MEND" else self.block
        if block is None or block.kind is not OLD_ENDS[word] or (self.explicit and word != "MEND"):
            self.read_statement(number, line)
            return
        block.ended = True
        network = self.network
        if network is not None and not (network.statements or network.title or network.comment):
            block.networks.remove(network)
            self.network = None

    def read_old_start(self, number: int, line: str) -> None:
        start = parse_old_start(line)
        if start is None or self.explicit:
            self.read_statement(number, line)
            return
        block, network = self.block, self.network
        if block is not None and network is not None and not network.statements:
            block.networks.remove(network)  # its header already belongs to the new block
            self.network = None
        else:
            network = None
        span = self.problems.span(number, start.column, start.length)
        new = RawBlock(start.kind, start.number, f"{start.kind.value}_{start.number}", span)
        self.open(new)
        if network is not None:
            self.enter(network, new)

    # -- statements

    def read_statement(self, number: int, line: str) -> None:
        block = self.need_block(number, line)
        if block is None:
            return
        network = self.network
        if network is not None and network.statements and not self.pending:
            last = network.statements[-1]
            if self.statements.goes_on(last, line):
                network.statements[-1] = self.statements.continued(last, number, line)
                return
        self.in_head = False
        if block.ended:
            block.ended = False  # once is enough
            span = self.problems.span(number, len(line) - len(line.lstrip()) + 1, len(first_word(line)))
            message = "this is never executed: the block has ended"
            self.problems.add("STL015", span, message, expected="SBR n or INT n to begin the next block")
        if network is None:
            network = RawNetwork(len(block.networks) + 1, "", self.problems.span(number, 1))
            self.enter(network, block)
        found = self.statements.read(number, line, tuple(self.pending))
        if found:
            self.pending = []
            network.statements += found

    # -- opening and closing

    def need_block(self, number: int, line: str) -> RawBlock | None:
        if self.block is None:
            if self.explicit:
                self.outside(number, line)
                return None
            comment, self.pending = self.pending, []
            self.open(RawBlock(PouKind.MAIN, 1, "MAIN", self.span(number, line), comment=comment))
        return self.block

    def outside(self, number: int, line: str, message: str = "this stands outside of every block") -> None:
        if not self.astray:
            expected = f"it between a header ({keyword_of(PouKind.MAIN)} MAIN:OB1) and its END"
            self.problems.add("STL007", self.span(number, line), message, expected=expected, where="")
        self.astray = True

    def open(self, block: RawBlock) -> None:
        self.close()
        self.block = block
        self.file.blocks.append(block)
        self.problems.where = f"{block.name} ({block.kind.value}{block.number})"

    def enter(self, network: RawNetwork, block: RawBlock) -> None:
        self.network = network
        block.networks.append(network)
        self.problems.where = f"{block.name} ({block.kind.value}{block.number}), network {network.number}"

    def close(self) -> None:
        self.end_network()
        self.network = None
        self.block = None
        self.in_head = False
        self.astray = False
        self.problems.where = ""

    def end_network(self) -> None:
        if self.network is not None:
            self.network.after += self.pending
            self.pending = []

    def finish(self) -> None:
        block = self.block
        if block is not None and block.keyword:
            last = max(number for number, line in enumerate(self.lines, 1) if line.strip())
            opened = ((block.span, "it begins here"),)
            message = f"the file ends in the middle of {block.name}; it may be cut off"
            expected = f"END_VAR and END_{block.keyword}" if self.section is not None else f"END_{block.keyword}"
            span = self.span(last, self.lines[last - 1])
            self.problems.add("STL004", span, message, expected=expected, related=opened)
        self.close()

    def span(self, number: int, line: str) -> Span:
        """The text of a line without the blanks around it."""
        return self.problems.span(number, len(line) - len(line.lstrip()) + 1, len(line.strip()))
