"""Which server the client commands talk to when nobody names one: that of ``./items.yaml``.

The file is only skimmed: it may be large, or broken just now, and the server that runs was started from it all the
same.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

import yaml

from pcaccess.project.model import Server
from pcaccess.project.network import DEFAULT_WEB, NetworkError, parse_web

PROJECT_FILE: Final = "items.yaml"
DEFAULT_ENDPOINT: Final = Server().endpoint


def default_url(project: Path | None = None) -> str:
    """The endpoint in the project file; the usual one when there is no file or it does not say."""
    return _skim(project, "endpoint") or DEFAULT_ENDPOINT


def default_web(project: Path | None = None) -> str | None:
    """``host:port`` of the web server in the project file, as above; None where it is off."""
    try:
        return parse_web(_skim(project, "web") or DEFAULT_WEB)
    except NetworkError:
        return DEFAULT_WEB


def _skim(project: Path | None, key: str) -> str | None:
    try:
        with (project or Path(PROJECT_FILE)).open(encoding="utf-8-sig") as file:
            return _of_server(file.read(), key)
    except (OSError, UnicodeDecodeError):
        return None


def _of_server(text: str, key: str) -> str | None:
    """``server: KEY:`` of a YAML text, found without reading further than that."""
    keys: list[str | None] = []
    """Of the mappings we are in: the key whose value comes next, None where a key comes next."""
    depth = 0
    """Levels below a value that is of no interest."""
    try:
        for event in yaml.parse(text, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader)):
            if isinstance(event, yaml.MappingStartEvent | yaml.SequenceStartEvent):
                interesting = isinstance(event, yaml.MappingStartEvent) and keys in ([], ["server"])
                if depth or not interesting:
                    depth += 1
                else:
                    keys.append(None)
            elif isinstance(event, yaml.MappingEndEvent | yaml.SequenceEndEvent):
                if depth:
                    depth -= 1
                else:
                    keys.pop()
                if not depth and keys:
                    keys[-1] = None if keys[-1] is not None else ""
            elif isinstance(event, yaml.ScalarEvent | yaml.AliasEvent) and not depth and keys:
                word = event.value if isinstance(event, yaml.ScalarEvent) else ""
                if keys[-1] is None:
                    keys[-1] = word
                elif keys == ["server", key]:
                    return word or None
                else:
                    keys[-1] = None
    except yaml.YAMLError:
        pass
    return None
