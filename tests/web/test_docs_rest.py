"""docs/rest.md names everything there is, and its examples are true."""

from __future__ import annotations

import json
import re
from pathlib import Path

from pcaccess.project.load import load_text
from pcaccess.project.network import WebClients
from pcaccess.web.refusals import KINDS
from tests.web.conftest import Serve, Served, message, tell

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "rest.md").read_text(encoding="utf-8")
SAMPLE = (ROOT / "items.yaml").read_text(encoding="utf-8")


def examples(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


async def test_every_endpoint_parameter_and_refusal_is_described(web: Served) -> None:
    table = PAGE[PAGE.index("## What there is") : PAGE.index("**Samples**")]
    for endpoint in web.server.web.endpoints:
        path = endpoint.path.replace(":path", "")
        assert f"`{endpoint.method} {path}`" in table, path
        assert all(f"`{parameter.name}" in table for parameter in endpoint.parameters), path
    refusals = PAGE[PAGE.index("## Refusals") : PAGE.index("## The websocket")]
    statuses: dict[str, int] = {}
    for kinds, status in re.findall(r"^\| (`.*?`) \| (\d+) \|", refusals, re.MULTILINE):
        statuses |= dict.fromkeys(re.findall(r"`([a-z-]+)`", kinds), int(status))
    assert statuses == {name: kind.status for name, kind in KINDS.items()}


async def test_the_session_goes_as_shown(start_web: Serve) -> None:
    (session,) = examples("console")
    async with start_web(SAMPLE) as web:
        for command, shown in re.findall(r"^\$ curl (.*)\n(.*)$", session, re.MULTILINE):
            url = re.search(r"http://127.0.0.1:8080(\S+)", command)
            body = re.search(r"--json (?:'(.*?)'|(\S+))", command)
            assert url is not None
            method = "PUT" if "-X PUT" in command else "POST" if body else "GET"
            content = (body[1] or body[2]).encode() if body else None
            headers = {"content-type": "application/json"} if body else {}
            answer = (await web.ask(method, url[1], content=content, headers=headers)).text
            times = r"\d{4}-\d\d-\d\dT[\d:.]+Z"
            assert re.sub(times, "TIME", answer) == re.sub(times, "TIME", shown)


async def test_the_websocket_says_what_is_shown(start_web: Serve) -> None:
    wishes, answer, changes = examples("json")
    async with start_web(SAMPLE) as web, web.socket() as socket:
        wish, _, _ = map(json.loads, wishes.splitlines())
        assert await tell(socket, **wish) == json.loads(answer)
        first, _ = map(json.loads, changes.splitlines())
        told = await message(socket)
        assert told.keys() == first.keys()
        assert (told["n"], told["quality"]) == (first["n"], first["quality"])


def test_the_project_text_is_one() -> None:
    text, opened, _ = examples("yaml")
    assert load_text(text).project.server.web == "127.0.0.1:8081"
    off = re.sub(r"^  web: .*\n# ", "  ", text, flags=re.MULTILINE)
    assert load_text(off).project.server.web is None
    assert load_text(opened).project.server.web_clients is WebClients.READERS
