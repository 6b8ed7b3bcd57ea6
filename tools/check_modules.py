"""Rules about modules that ruff does not know.

- over 400 lines a module is asking to be two (reported); over 800 it is refused;
- an ``__init__`` holds imports, ``__all__`` and ``__version__`` and nothing else;
- a task belongs to a TaskGroup: ``x.create_task`` is refused unless ``x`` is visibly one, because the result of
  a bare one can be lost with its exception. Tests are free to: a fixture cannot hold a group over its yield.

Exit code: 1 when something is refused; the last lines name the rule and the file.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Final

QUESTION: Final = 400
REFUSED: Final = 800
FOLDERS: Final = ("pcaccess", "tools", "bench", "tests", "examples")
INIT_NAMES: Final = frozenset({"__all__", "__version__"})


def length_of(path: Path, text: str) -> tuple[list[str], list[str]]:
    """(refusals, questions) about the number of lines."""
    lines = text.count("\n")
    if lines > REFUSED:
        return [f"{path}: {lines} lines; a module over {REFUSED} must be split"], []
    if lines > QUESTION:
        return [], [f"{path}: {lines} lines; is it two things?"]
    return [], []


def init_content(path: Path, tree: ast.Module) -> Iterator[str]:
    if path.name != "__init__.py":
        return
    for node in tree.body:
        is_text = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        target: ast.expr | None = node.target if isinstance(node, ast.AnnAssign) else None
        if isinstance(node, ast.Assign) and len(node.targets) == 1:
            target = node.targets[0]
        is_name = isinstance(target, ast.Name) and target.id in INIT_NAMES
        if not (is_text or is_name or isinstance(node, ast.Import | ast.ImportFrom)):
            yield f"{path}:{node.lineno}: an __init__ only re-exports; give this a module of its own"


def last_name(node: ast.expr | None) -> str:
    """``group`` of both ``group`` and ``self.group``; empty for anything else."""
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else ""


def is_task_group(node: ast.expr | None) -> bool:
    """``TaskGroup``, ``asyncio.TaskGroup``, a call of it, or one side of ``TaskGroup | None``."""
    if isinstance(node, ast.Call):
        return is_task_group(node.func)
    if isinstance(node, ast.BinOp):
        return is_task_group(node.left) or is_task_group(node.right)
    return last_name(node) == "TaskGroup"


def task_groups(tree: ast.Module) -> set[str]:
    """Names that hold a TaskGroup somewhere in the module."""
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.withitem) and is_task_group(node.context_expr):
            names.add(last_name(node.optional_vars))
        elif isinstance(node, ast.arg) and is_task_group(node.annotation):
            names.add(node.arg)
        elif isinstance(node, ast.AnnAssign) and is_task_group(node.annotation):
            names.add(last_name(node.target))
        elif isinstance(node, ast.Assign) and is_task_group(node.value):
            names.update(last_name(target) for target in node.targets)
    return names


def bare_tasks(path: Path, tree: ast.Module) -> Iterator[str]:
    groups = task_groups(tree)
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call) or last_name(node.func) not in ("create_task", "ensure_future"):
            continue
        if not (isinstance(node.func, ast.Attribute) and last_name(node.func.value) in groups):
            yield f"{path}:{node.lineno}: bare {last_name(node.func)}; use an asyncio.TaskGroup"


def check(paths: list[Path]) -> tuple[list[str], list[str]]:
    """(refusals, questions) about these files."""
    refused: list[str] = []
    questions: list[str] = []
    for path in paths:
        text = path.read_text(encoding="utf-8")
        tree = ast.parse(text, str(path))
        too_long, long = length_of(path, text)
        refused += [*too_long, *init_content(path, tree)]
        if path.parts[0] != "tests":
            refused += bare_tasks(path, tree)
        questions += long
    return refused, questions


def main() -> int:
    refused, questions = check(sorted(path for folder in FOLDERS for path in Path(folder).rglob("*.py")))
    for line in questions:
        print(f"question: {line}")
    for line in refused:
        print(f"refused: {line}")
    return 1 if refused else 0


if __name__ == "__main__":
    sys.exit(main())
