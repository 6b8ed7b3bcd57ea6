"""Why a request is not done: every kind of refusal with its HTTP status, answered as problem JSON.

Source:   RFC 9457 (``application/problem+json``): ``type`` is ``urn:pcaccess:problem:KIND``, ``detail`` is for people.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final

import orjson

from pcaccess.links.base import Outcome
from pcaccess.web.answers import Answer, Headers

MEDIA_TYPE: Final = "application/problem+json"
URN: Final = "urn:pcaccess:problem:"


@dataclass(frozen=True, slots=True)
class Kind:
    """A row of the register: HTTP status and what it means, in one line."""

    status: int
    title: str


KINDS: Final[Mapping[str, Kind]] = MappingProxyType(
    {
        "bad-request": Kind(400, "the request says something that cannot be understood"),
        "not-writable": Kind(403, "the item is read-only"),
        "not-readable": Kind(403, "the item is write-only"),
        "only-reading": Kind(403, "other machines may only read"),
        "cross-site": Kind(403, "a page of another site may not ask"),
        "not-found": Kind(404, "there is nothing at this path"),
        "unknown-item": Kind(404, "there is no such item"),
        "unknown-group": Kind(404, "there is no such group"),
        "method-not-allowed": Kind(405, "this path does not do that"),
        "too-large": Kind(413, "the request is larger than the gateway takes"),
        "unsupported-type": Kind(415, "the body is of a kind that is not taken here"),
        "wrong-host": Kind(421, "the request was meant for another host"),
        "type-mismatch": Kind(422, "the value is of the wrong kind for the item's type"),
        "out-of-range": Kind(422, "the value does not fit the item"),
        "internal": Kind(500, "the gateway made a mistake"),
        "configuration-error": Kind(502, "the PLC does not have that"),
        "device-failure": Kind(502, "the PLC reports a failure"),
        "not-connected": Kind(503, "the PLC is not connected"),
        "too-busy": Kind(503, "the gateway has no more room for requests of this kind"),
        "no-communication": Kind(504, "the PLC did not answer"),
    }
)

OF_OUTCOME: Final[Mapping[Outcome, tuple[str, str]]] = MappingProxyType(
    {
        Outcome.NOT_WRITABLE: ("not-writable", "BadNotWritable"),
        Outcome.TYPE_MISMATCH: ("type-mismatch", "BadTypeMismatch"),
        Outcome.OUT_OF_RANGE: ("out-of-range", "BadOutOfRange"),
        Outcome.CONFIG_ERROR: ("configuration-error", "BadConfigurationError"),
        Outcome.NOT_CONNECTED: ("not-connected", "BadNotConnected"),
        Outcome.COMM_FAILURE: ("no-communication", "BadNoCommunication"),
        Outcome.DEVICE_FAILURE: ("device-failure", "BadDeviceFailure"),
    }
)
"""What a write that was not done is: kind of refusal, and OPC UA status name."""


class Refusal(Exception):
    """Answer with this kind of refusal. ``detail`` says what is wrong and what to do; ``more`` is for programs."""

    def __init__(self, kind: str, detail: str, **more: Any) -> None:
        super().__init__(detail)
        self.kind = kind
        self.status = KINDS[kind].status
        self.more = more

    def as_json(self) -> dict[str, Any]:
        """The answer's body."""
        known = KINDS[self.kind]
        common = {"type": URN + self.kind, "title": known.title, "status": known.status, "detail": str(self)}
        return common | self.more

    def answer(self, more: Headers = ()) -> Answer:
        return Answer(orjson.dumps(self.as_json()), MEDIA_TYPE, self.status, more)
