"""Browse in portions: what is not sent yet is a continuation point, not a list in memory.

A folder may hold 100,000 items, and describing one takes microseconds: references are described when they are sent.

Source:   OPC UA Part 4, 5.8.2 Browse, 5.8.3 BrowseNext, 7.9 ContinuationPoint.
"""

from __future__ import annotations

import secrets
from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice

from asyncua import ua
from asyncua.server.address_space import AddressSpace, ViewService
from asyncua.ua.attribute_ids import AttributeIds
from asyncua.ua.status_codes import StatusCodes

from pcaccess.opcua.limits import MAX_CONTINUATION_POINTS, MAX_REFERENCES, MAX_REFERENCES_PER_REQUEST
from pcaccess.opcua.nodestore import NodeStore

References = Iterator[ua.ReferenceDescription]


@dataclass(slots=True)
class Rest:
    """References of one node that were asked for and not sent yet."""

    references: References
    portion: int
    """At most so many in one answer."""


class ContinuationPoints:
    """What one session has still to fetch, by a number that nobody can guess."""

    def __init__(self) -> None:
        self._rests: OrderedDict[bytes, Rest] = OrderedDict()
        self._made = 0

    def __len__(self) -> int:
        return len(self._rests)

    def begin(self) -> None:
        """A request begins: those of earlier requests may be forgotten for it, its own may not (7.9)."""
        self._made = 0

    def keep(self, rest: Rest) -> bytes | None:
        """A new continuation point, or None when this request has all there are."""
        if self._made >= MAX_CONTINUATION_POINTS:
            return None
        self._made += 1
        if len(self._rests) >= MAX_CONTINUATION_POINTS:
            self._rests.popitem(last=False)
        point = secrets.token_bytes(16)
        self._rests[point] = rest
        return point

    def take(self, point: bytes | None) -> Rest | None:
        """A continuation point is used once (7.9); None when it is not known (any more)."""
        return self._rests.pop(point, None) if point else None


class Views(ViewService):
    """asyncua's view service, with references one by one and the sub-type test remembered.

    asyncua walked the type tree once per reference.
    """

    def __init__(self, aspace: AddressSpace, nodes: NodeStore) -> None:
        super().__init__(aspace)
        self._nodes = nodes
        self._suitable: dict[tuple[ua.NodeId, ua.NodeId, bool], bool] = {}

    def _suitable_reftype(self, ref1: ua.NodeId, ref2: ua.NodeId, subtypes: bool) -> bool:
        key = (ref1, ref2, subtypes)
        known = self._suitable.get(key)
        if known is None:
            if len(self._suitable) > 1000:
                self._suitable.clear()
            known = self._suitable[key] = super()._suitable_reftype(ref1, ref2, subtypes)
        return known

    # ------------------------------------------------------------------ Browse

    def browse_in_portions(self, params: ua.BrowseParameters, points: ContinuationPoints) -> list[ua.BrowseResult]:
        """The Browse service of one session."""
        points.begin()
        room = MAX_REFERENCES_PER_REQUEST
        asked = int(params.RequestedMaxReferencesPerNode)
        portion = min(asked, MAX_REFERENCES) if asked > 0 else MAX_REFERENCES
        results = []
        for description in params.NodesToBrowse:
            result = self._check(description)
            if result is None:
                result = self._portion(Rest(self.matching(description), portion), room, points)
                room -= len(result.References)
            results.append(result)
        return results

    def browse_next(self, params: ua.BrowseNextParameters, points: ContinuationPoints) -> list[ua.BrowseResult]:
        """The BrowseNext service of one session."""
        points.begin()
        room = MAX_REFERENCES_PER_REQUEST
        results = []
        for point in params.ContinuationPoints:
            rest = points.take(point)
            if rest is None:
                results.append(_refused(StatusCodes.BadContinuationPointInvalid))
            elif params.ReleaseContinuationPoints:
                results.append(ua.BrowseResult())
            else:
                result = self._portion(rest, room, points)
                room -= len(result.References)
                results.append(result)
        return results

    def _check(self, description: ua.BrowseDescription) -> ua.BrowseResult | None:
        if description.NodeId not in self._aspace:
            return _refused(StatusCodes.BadNodeIdUnknown)
        if description.BrowseDirection not in tuple(ua.BrowseDirection)[:3]:
            return _refused(StatusCodes.BadBrowseDirectionInvalid)
        wanted = description.ReferenceTypeId
        if not wanted.is_null():
            known = self._aspace.read_attribute_value(wanted, AttributeIds.NodeClass)
            if known.Value is None or known.Value.Value != ua.NodeClass.ReferenceType:
                return _refused(StatusCodes.BadReferenceTypeIdInvalid)
        return None

    def _portion(self, rest: Rest, room: int, points: ContinuationPoints) -> ua.BrowseResult:
        result = ua.BrowseResult()
        result.References = list(islice(rest.references, max(0, min(rest.portion, room))))
        following = next(rest.references, None)
        if following is not None:
            point = points.keep(Rest(_chain(following, rest.references), rest.portion))
            if point is None:
                return _refused(StatusCodes.BadNoContinuationPoints)
            result.ContinuationPoint = ua.ByteString(point)
        return result

    def matching(self, wanted: ua.BrowseDescription) -> References:
        """References that a Browse asks for, each described when it is reached."""
        for direction, reference_type, described in self._nodes.references_of(wanted.NodeId):
            if not self._suitable_direction(wanted.BrowseDirection, direction):
                continue
            if not self._suitable_reftype(wanted.ReferenceTypeId, reference_type, wanted.IncludeSubtypes):
                continue
            description = described()
            if description is None:  # the far end is gone
                continue
            if wanted.NodeClassMask and not wanted.NodeClassMask & description.NodeClass:
                continue
            yield description


def _chain(first: ua.ReferenceDescription, rest: References) -> References:
    yield first
    yield from rest


def _refused(status: int) -> ua.BrowseResult:
    return ua.BrowseResult(StatusCode=ua.StatusCode(ua.UInt32(status)))
