"""Writing a project file so that there is always a whole one: the old or the new."""

from __future__ import annotations

import contextlib
import os
import secrets
from pathlib import Path

from pcaccess.project.load import Loaded, load_text


def save_project(path: Path, text: str) -> Loaded:
    """Put ``text`` in the place of ``path`` when it is a project without errors.

    Raises ProblemError, or OSError, with the old file as it was.
    """
    target = path.resolve()  # behind a link stands the file that is meant
    loaded = load_text(text, str(path), target.parent)
    replace_file(target, text)
    return loaded


def replace_file(path: Path, text: str) -> None:
    """Write beside ``path`` and change places; whoever reads meanwhile sees one or the other."""
    fresh = path.with_name(f".{path.name}.{secrets.token_hex(4)}.new")
    handle = os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
    try:
        with os.fdopen(handle, "w", encoding="utf-8", newline="\n") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        with contextlib.suppress(FileNotFoundError):
            fresh.chmod(path.stat().st_mode & 0o7777)
        fresh.replace(path)
    except BaseException:
        fresh.unlink(missing_ok=True)
        raise
