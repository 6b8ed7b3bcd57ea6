"""The rules of tools/check_modules.py, each with a module that breaks it and one that does not."""

from __future__ import annotations

from pathlib import Path

import pytest
from check_modules import check


def refusals(folder: Path, text: str, name: str = "module.py") -> list[str]:
    path = folder / name
    path.write_text(text)
    return [line.removeprefix(f"{path}") for line in check([path])[0]]


def test_800_lines_are_allowed_and_one_more_is_not(tmp_path: Path) -> None:
    assert refusals(tmp_path, "x = 1\n" * 800) == []
    assert refusals(tmp_path, "x = 1\n" * 801) == [": 801 lines; a module over 800 must be split"]


def test_over_400_lines_is_a_question_only(tmp_path: Path) -> None:
    path = tmp_path / "long.py"
    path.write_text("x = 1\n" * 401)
    assert check([path]) == ([], [f"{path}: 401 lines; is it two things?"])


@pytest.mark.parametrize(
    "text",
    [
        "async def f():\n    async with asyncio.TaskGroup() as group:\n        group.create_task(g())\n",
        "def f(group: asyncio.TaskGroup):\n    group.create_task(g())\n",
        "class A:\n    group: TaskGroup | None\n    def f(self):\n        self.group.create_task(g())\n",
        "class A:\n    def f(self):\n        self.group = asyncio.TaskGroup()\n        self.group.create_task(g())\n",
    ],
)
def test_a_task_in_a_group_is_allowed(tmp_path: Path, text: str) -> None:
    assert refusals(tmp_path, text) == []


@pytest.mark.parametrize(
    "call", ["asyncio.create_task(g())", "loop.create_task(g())", "create_task(g())", "asyncio.ensure_future(g())"]
)
def test_a_bare_task_is_refused(tmp_path: Path, call: str) -> None:
    name = "ensure_future" if "ensure" in call else "create_task"
    assert refusals(tmp_path, f"x = {call}\n") == [f":1: bare {name}; use an asyncio.TaskGroup"]


def test_an_init_may_reexport(tmp_path: Path) -> None:
    text = '"""Doc."""\nfrom a import b\n__all__ = ["b"]\n__version__: Final = "1"\n'
    assert refusals(tmp_path, text, "__init__.py") == []


def test_an_init_may_not_define(tmp_path: Path) -> None:
    found = refusals(tmp_path, "def f(): ...\n", "__init__.py")
    assert found == [":1: an __init__ only re-exports; give this a module of its own"]


def test_tests_may_keep_a_task_of_their_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for folder in ("tests", "pcaccess"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "module.py").write_text("task = loop.create_task(g())\n")
    assert check([Path("tests/module.py")]) == ([], [])
    assert len(check([Path("pcaccess/module.py")])[0]) == 1
