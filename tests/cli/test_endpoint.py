"""Which server is meant when nobody names one."""

from __future__ import annotations

from pathlib import Path

import pytest

from pcaccess.cli.endpoint import DEFAULT_ENDPOINT, default_url

URL = "opc.tcp://127.0.0.1:4999/plant"


@pytest.mark.parametrize(
    "text",
    [
        f"server:\n  endpoint: {URL}\n",
        f"links: [{{name: a, server: {{endpoint: no}}}}]\nserver: {{read_timeout: 1s, endpoint: '{URL}'}}\n",
        f"server:\n  endpoint: {URL}\nlinks: [ this is broken\n",
        f"groups:\n  - [endpoint, server]\nserver: {{other: [a, {{endpoint: b}}], endpoint: {URL}}}\n",
        f"? [a, b]\n: endpoint\nserver: {{endpoint: {URL}}}\n",
    ],
)
def test_the_project_file_says_it(tmp_path: Path, text: str) -> None:
    project = tmp_path / "items.yaml"
    project.write_text(text)
    assert default_url(project) == URL


@pytest.mark.parametrize(
    "text",
    [
        "",
        "links: []\n",
        "server: endpoint\n",
        "server: [endpoint, x]\n",
        "endpoint: opc.tcp://h:1\n",
        "server: {endpoint: }\n",
        "- server\n- {endpoint: opc.tcp://h:1}\n",
        "a: {server: {endpoint: opc.tcp://h:1}}\n",
        "\x00",
    ],
)
def test_otherwise_it_is_the_usual_one(tmp_path: Path, text: str) -> None:
    project = tmp_path / "items.yaml"
    project.write_text(text)
    assert default_url(project) == DEFAULT_ENDPOINT


def test_without_a_project_file_it_is_the_usual_one(tmp_path: Path) -> None:
    assert default_url(tmp_path / "items.yaml") == DEFAULT_ENDPOINT
