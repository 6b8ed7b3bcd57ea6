"""Mutation check: seeded faults in what executes a program, and which test catches each. ``make mutants`` runs it.

``tools/faults`` lists the faults. Each is put into a copy of the clone, alone, and the tests it names run there; when
they do not catch it, the whole of ``SUITE`` does. The same tests pass without a fault, else nothing is shown.

Exit code: 1 when a fault survives, when its text does not stand in its file exactly once, or when the tests fail
           without any fault; 2 for a fault that is not in the list.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Any, Final

import faults
from faults.fault import Fault

ROOT: Final = Path(__file__).parent.parent
SUITE: Final = ("tests/differential tests/plc", "tests/conformance")
"""What a fault has to survive; in parts, so that they can run beside each other."""
COPIED: Final = ("pcaccess", "tests", "tools", "docs", "examples", "pyproject.toml")
OPTIONS: Final = "-x -v --tb=no --no-header -p no:cacheprovider -p no:faulthandler -o addopts=--import-mode=importlib"
_NO_TESTS: Final = (4, 5)
"""Exit codes of pytest."""
PATIENCE: Final = 300.0
"""Seconds for one run of tests; more is a fault that hangs."""
_RESULT: Final = re.compile(r"^(?P<test>\S+::.+?) (?P<result>PASSED|FAILED|ERROR|SKIPPED|XFAIL)\b", re.MULTILINE)
_COLLECTING: Final = re.compile(r"^ERROR (?P<test>\S+)", re.MULTILINE)
_RUNNING: Final = re.compile(r"^(?P<test>\S+::.+?)\s*\Z", re.MULTILINE)


class Stale(Exception):
    """The fault's text does not stand in the source exactly once."""


class Unsound(Exception):
    """The tests do not pass without a fault."""


class Outcome(Enum):
    CAUGHT = "caught"
    SURVIVED = "SURVIVED"
    STALE = "STALE"


@dataclass(frozen=True, slots=True)
class Finding:
    """What became of one fault."""

    fault: Fault
    outcome: Outcome
    by: str = ""
    """The test that failed and how; for a stale fault, what is wrong with it."""
    seconds: float = 0.0

    def __str__(self) -> str:
        return f"{self.outcome.value:<8}  {self.fault.name:<32}  {self.by or self.fault.what}  ({self.seconds:.1f} s)"

    def as_json(self) -> dict[str, Any]:
        found = {"outcome": self.outcome.value.lower(), "by": self.by or None, "seconds": round(self.seconds, 2)}
        return {"name": self.fault.name, "what": self.fault.what, "file": self.fault.file, **found}


def faulty(root: Path, fault: Fault) -> str:
    """The text of the fault's file with the fault in it. Raises Stale."""
    try:
        text = (root / fault.file).read_text(encoding="utf-8")
    except OSError as error:
        raise Stale(f"{fault.file}: {error.strerror}") from None
    count = text.count(fault.old)
    if count != 1:
        raise Stale(f"its text stands {count} times in {fault.file}, not once")
    return text.replace(fault.old, fault.new)


@dataclass
class Campaign:
    """Faults, where they are, and what should find them."""

    root: Path = ROOT
    suite: Sequence[str] = SUITE
    patience: float = PATIENCE
    _sound: dict[str, threading.Lock | None] = field(default_factory=dict)
    """Tests that are known to pass without a fault (None), or that somebody is running to find out."""
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def try_out(self, fault: Fault) -> Finding:
        """Put one fault in and look who notices. Raises Unsound."""
        start = time.perf_counter()
        try:
            text = faulty(self.root, fault)
        except Stale as error:
            return Finding(fault, Outcome.STALE, str(error))
        with self._copy() as folder:
            (folder / fault.file).write_text(text, encoding="utf-8")
            for tests in (fault.tests, *self.suite):
                by = self._failure(folder, tests)
                if by is not None:
                    self.prove(tests)
                    return Finding(fault, Outcome.CAUGHT, by, time.perf_counter() - start)
        return Finding(fault, Outcome.SURVIVED, "", time.perf_counter() - start)

    def prove(self, tests: str) -> None:
        """See these tests pass without a fault, once. Raises Unsound."""
        with self._lock:
            lock = self._sound.setdefault(tests, threading.Lock())
        if lock is None:
            return
        with lock:
            if self._sound[tests] is None:
                return
            with self._copy() as folder:
                by = self._failure(folder, tests)
            if by is not None:
                raise Unsound(f"without any fault: {by}")
            self._sound[tests] = None

    def prove_suite(self, workers: int) -> None:
        """See everything pass without a fault: what the faults name is a part of it. Raises Unsound."""
        with ThreadPoolExecutor(workers) as pool:
            for one in [pool.submit(self.prove, tests) for tests in self.suite]:
                one.result()

    def trust(self, tests: str) -> None:
        """These tests are a part of others that were seen to pass."""
        self._sound[tests] = None

    @contextmanager
    def _copy(self) -> Iterator[Path]:
        with tempfile.TemporaryDirectory(prefix="mutant-", ignore_cleanup_errors=True) as name:
            folder = Path(name)
            for part in COPIED:
                source = self.root / part
                if source.is_dir():
                    # copy2 keeps the times, so compiled modules stay valid; that of the fault's file does not
                    shutil.copytree(source, folder / part)
                elif source.exists():
                    shutil.copy2(source, folder / part)
            yield folder

    def _failure(self, folder: Path, tests: str) -> str | None:
        """Run tests in a copy; the first that fails and how, None when all pass."""
        command = [sys.executable, "-m", "pytest", *shlex.split(OPTIONS), *shlex.split(tests)]
        environment = {**os.environ, "PYTHONPATH": str(folder), "HYPOTHESIS_PROFILE": "mutants"}
        process = subprocess.Popen(
            command,
            cwd=folder,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            start_new_session=True,
        )
        try:
            output, _ = process.communicate(timeout=self.patience)
        except subprocess.TimeoutExpired:
            _end(process)
            output, _ = process.communicate()
            return f"{_running(output)}: does not end"
        finally:
            _end(process)
        return _verdict(process.returncode, output)


def _end(process: subprocess.Popen[str]) -> None:
    """The process and what it started."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)


def _verdict(code: int, output: str) -> str | None:
    if code == 0:
        return None
    if code < 0:
        return f"{_running(output)}: the process died of {signal.Signals(-code).name}"
    if code in _NO_TESTS:
        raise Unsound(f"pytest finds no tests to run: {output.strip().splitlines()[-1]}")
    failed = next((m["test"] for m in _RESULT.finditer(output) if m["result"] in ("FAILED", "ERROR")), None)
    if failed is not None:
        return failed
    broken = _COLLECTING.search(output)
    return f"{broken['test']}: cannot be collected" if broken else f"pytest ended with {code}"


def _running(output: str) -> str:
    """The test that was running when the output ended."""
    last = _RUNNING.search(output)
    return last["test"] if last else "the tests"


def report(findings: Sequence[Finding], seconds: float) -> str:
    """The last words."""
    lines = [
        f"{finding.outcome.value}: {finding.fault.name} ({finding.fault.file}): {finding.by or finding.fault.what}"
        for finding in findings
        if finding.outcome is not Outcome.CAUGHT
    ]
    caught = sum(finding.outcome is Outcome.CAUGHT for finding in findings)
    return "\n".join([*lines, f"{caught} of {len(findings)} faults caught in {seconds:.0f} s"])


def run(campaign: Campaign, chosen: Sequence[Fault], *, everything: bool, workers: int, as_json: bool) -> int:
    """The campaign, told as it goes; returns the exit code."""
    start = time.perf_counter()
    findings: list[Finding] = []
    if everything:
        campaign.prove_suite(workers)
        for fault in chosen:
            campaign.trust(fault.tests)
    with ThreadPoolExecutor(workers) as pool:
        waiting = [pool.submit(campaign.try_out, fault) for fault in chosen]
        try:
            for done in as_completed(waiting):
                findings.append(done.result())
                if not as_json:
                    print(f"{len(findings):>3}/{len(chosen)} {findings[-1]}", flush=True)
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    if as_json:
        print(json.dumps([finding.as_json() for finding in findings], indent=1))
    else:
        print(report(findings, time.perf_counter() - start))
    return 0 if all(finding.outcome is Outcome.CAUGHT for finding in findings) else 1


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description="Seeded faults, and which test catches each.")
    parser.add_argument("--only", metavar="NAME", action="append", help="this fault alone; may be given several times")
    parser.add_argument("--list", action="store_true", help="say which faults there are")
    parser.add_argument("--json", action="store_true", help="one object for each fault")
    parser.add_argument("--workers", metavar="N", type=int, default=os.cpu_count() or 1, help="default: all cores")
    options = parser.parse_args(arguments)
    known = {fault.name: fault for fault in faults.ALL}
    unknown = [name for name in options.only or () if name not in known]
    if unknown:
        parser.error(f"there is no fault {', '.join(unknown)}; --list names them")
    chosen = [known[name] for name in options.only] if options.only else list(faults.ALL)
    if options.list:
        for fault in chosen:
            print(f"{fault.name:<32}  {fault.file}: {fault.what}")
        return 0
    try:
        return run(Campaign(), chosen, everything=not options.only, workers=options.workers, as_json=options.json)
    except Unsound as error:
        print(error, file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
