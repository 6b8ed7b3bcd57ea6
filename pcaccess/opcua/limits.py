"""How much one client may ask for at once: published in the address space, and enforced.

Source:   OPC UA Part 5, 6.3.11 OperationLimitsType and 6.3.2 ServerCapabilitiesType; Part 4, 7.38.2: a request with
          more operations than the server takes is answered BadTooManyOperations.
"""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType
from typing import Final

from asyncua import ua
from asyncua.common.utils import ServiceError
from asyncua.ua.object_ids import ObjectIds
from asyncua.ua.status_codes import StatusCodes

MAX_NODES_PER_READ: Final = 10_000
MAX_NODES_PER_WRITE: Final = 10_000
MAX_NODES_PER_BROWSE: Final = 1_000
MAX_NODES_PER_REGISTER: Final = 10_000
MAX_PATHS_PER_TRANSLATE: Final = 1_000
MAX_METHODS_PER_CALL: Final = 100
MAX_MONITORED_ITEMS_PER_CALL: Final = 10_000

MAX_REFERENCES: Final = 1_000
"""References of one node in one answer; the rest comes by BrowseNext."""
MAX_REFERENCES_PER_REQUEST: Final = 5_000
MAX_CONTINUATION_POINTS: Final = 100
"""Of one session; making one more forgets the oldest."""
MAX_REGISTERED_NODES: Final = 100_000
"""Of one session; further ones are answered with the NodeId they came with."""

MAX_FRAME: Final = 65_535
"""Bytes of one chunk. Clients learn it from Acknowledge; whoever sends more is cut off before it is buffered."""
MIN_FRAME: Final = 8_192
"""Part 6, 7.1.2.3: no client may ask for smaller chunks."""
MAX_MESSAGE: Final = 16 * 1024 * 1024
MAX_CONNECTIONS: Final = 200

_LIMITS: Final = "Server_ServerCapabilities_OperationLimits_"
PUBLISHED: Final = MappingProxyType(
    {
        getattr(ObjectIds, _LIMITS + "MaxNodesPerRead"): ua.Variant(MAX_NODES_PER_READ, ua.VariantType.UInt32),
        getattr(ObjectIds, _LIMITS + "MaxNodesPerWrite"): ua.Variant(MAX_NODES_PER_WRITE, ua.VariantType.UInt32),
        getattr(ObjectIds, _LIMITS + "MaxNodesPerBrowse"): ua.Variant(MAX_NODES_PER_BROWSE, ua.VariantType.UInt32),
        getattr(ObjectIds, _LIMITS + "MaxNodesPerRegisterNodes"): ua.Variant(
            MAX_NODES_PER_REGISTER, ua.VariantType.UInt32
        ),
        getattr(ObjectIds, _LIMITS + "MaxNodesPerTranslateBrowsePathsToNodeIds"): ua.Variant(
            MAX_PATHS_PER_TRANSLATE, ua.VariantType.UInt32
        ),
        getattr(ObjectIds, _LIMITS + "MaxNodesPerMethodCall"): ua.Variant(MAX_METHODS_PER_CALL, ua.VariantType.UInt32),
        getattr(ObjectIds, _LIMITS + "MaxMonitoredItemsPerCall"): ua.Variant(
            MAX_MONITORED_ITEMS_PER_CALL, ua.VariantType.UInt32
        ),
        ObjectIds.Server_ServerCapabilities_MaxBrowseContinuationPoints: ua.Variant(
            MAX_CONTINUATION_POINTS, ua.VariantType.UInt16
        ),
    }
)
"""Standard variable and what it says."""


def check_operations(operations: Sequence[object] | None, most: int) -> None:
    """Refuse a request that holds nothing or too much."""
    if not operations:
        raise ServiceError(StatusCodes.BadNothingToDo)
    if len(operations) > most:
        raise ServiceError(StatusCodes.BadTooManyOperations)
