"""An OPC UA server as the client commands use it: read, write, browse, be told of changes.

Everything goes in requests of bounded size. What the server says of one node stays that node's affair; what ends the
connection is :class:`Failed`, in words that say what to do.

Works with any server; with ours (it has the namespace ``urn:pcaccess:items``) nodes have their item IDs as names.
"""

from __future__ import annotations

import asyncio
import logging
import os
import re
import socket
from collections.abc import AsyncIterator, Awaitable, Iterable, Iterator, Sequence
from contextlib import asynccontextmanager
from itertools import islice
from typing import Final, TypeVar

from asyncua import ua
from asyncua.client.client import Client
from asyncua.ua.attribute_ids import AttributeIds
from asyncua.ua.object_ids import ObjectIds
from asyncua.ua.status_codes import StatusCodes, get_name_and_doc
from asyncua.ua.uaerrors import UaError, UaStatusCodeError

from pcaccess.cli.failures import Failed
from pcaccess.opcua.ids import ITEMS_URI, SYSTEM_URI

T = TypeVar("T")
MAX_NODES: Final = 1000
"""Nodes in one request."""
PATIENCE: Final = 5.0
"""Seconds a server has for an answer."""
VALUE: Final = AttributeIds.Value
_NODE_ID: Final = re.compile(r"(ns=\d+;)?[isgb]=.*", re.DOTALL)
_OF_EVERY_SERVER: Final = frozenset({ObjectIds.Server, ObjectIds.Aliases, ObjectIds.Locations})
"""Standard nodes below Objects, which hold no items."""

Change = tuple[int, ua.DataValue]
"""Handle of a monitored item, and its new value."""


class Lost(Failed):
    """The connection ended while it was in use."""


class Remote:
    """One session. Make it with :func:`connect`."""

    def __init__(self, client: Client, url: str, patience: float, namespaces: Sequence[str]) -> None:
        self._client = client
        self._patience = patience
        self.url = url
        self.items = _index(namespaces, ITEMS_URI)
        """Namespace of items when the server is ours."""
        self.system = _index(namespaces, SYSTEM_URI)
        self._changes: asyncio.Queue[list[Change] | None] = asyncio.Queue()
        """None: the subscription ended."""

    def be_patient(self, patience: float) -> None:
        """Give answers so many seconds from now on."""
        protocol = self._client.uaclient.protocol
        assert protocol is not None
        self._patience = protocol.timeout = patience

    async def _ask(self, answer: Awaitable[T]) -> T:
        try:
            return await answer
        except TimeoutError:
            raise Lost(f"{self.url} did not answer within {self._patience:g} s") from None
        except OSError:
            raise Lost(f"the connection to {self.url} was lost") from None
        except UaStatusCodeError as error:
            raise Failed(f"{self.url} refused: {status_text(int(error.code))}") from None

    # ------------------------------------------------------------------ names

    def node(self, name: str) -> ua.NodeId | None:
        """The NodeId of an item ID, run-time name or NodeId text; None for a name that is none of these here."""
        if _NODE_ID.fullmatch(name):
            try:
                return ua.NodeId.from_string(name)
            except (UaError, ValueError):
                return None
        if "/" in name and "," not in name:
            return self.of_system(name)
        return None if self.items is None else ua.NodeId(ua.String(name), ua.Int16(self.items))

    def name(self, node: ua.NodeId) -> str:
        """What people call the node: its item ID (``MicroWin.NewPLC/Mode``), or on foreign servers its NodeId."""
        if node.NamespaceIndex in (self.items, self.system) and isinstance(node.Identifier, str):
            return node.Identifier
        return str(node.to_string())

    def belonging(self, node: ua.NodeId, name: str) -> ua.NodeId | None:
        """Something of an item in the system namespace of our server: its Quality, its Address ..."""
        return self.of_system(f"{self.name(node)}/{name}") if node.NamespaceIndex == self.items else None

    def group(self, name: str) -> ua.NodeId | None:
        """A group of our server, or with ``NAME/UpdateRate`` something of it."""
        return self.of_system(f"Groups/{name}")

    def groups(self) -> ua.NodeId | None:
        """The node that all groups hang under."""
        return self.of_system("Groups")

    def of_system(self, path: str) -> ua.NodeId | None:
        """A node of our server's own namespace."""
        return None if self.system is None else ua.NodeId(ua.String(path), ua.Int16(self.system))

    # ------------------------------------------------------------------ services

    async def read(self, wanted: Iterable[tuple[ua.NodeId, AttributeIds]]) -> list[ua.DataValue]:
        """Attributes of nodes; the status of each says how it went."""
        values: list[ua.DataValue] = []
        for some in _batches(wanted, MAX_NODES):
            nodes = [ua.ReadValueId(NodeId=node, AttributeId=attribute) for node, attribute in some]
            params = ua.ReadParameters(
                MaxAge=ua.Duration(0), TimestampsToReturn=ua.TimestampsToReturn.Both, NodesToRead=nodes
            )
            values += await self._ask(self._client.uaclient.read(params))
        return values

    async def read_values(self, nodes: Iterable[ua.NodeId]) -> list[ua.DataValue]:
        return await self.read((node, VALUE) for node in nodes)

    async def write(self, writes: Iterable[tuple[ua.NodeId, ua.Variant]]) -> list[int]:
        """Values to nodes, in order; the StatusCode of each."""
        results: list[int] = []
        for some in _batches(writes, MAX_NODES):
            nodes = [ua.WriteValue(NodeId=node, AttributeId=VALUE, Value=ua.DataValue(value)) for node, value in some]
            answered = await self._ask(self._client.uaclient.write(ua.WriteParameters(NodesToWrite=nodes)))
            results += [int(status.value) for status in answered]
        return results

    async def call(self, owner: ua.NodeId, method: ua.NodeId, arguments: Sequence[ua.Variant]) -> ua.CallMethodResult:
        """Call a method; the result says how it went."""
        request = ua.CallMethodRequest(ObjectId=owner, MethodId=method, InputArguments=list(arguments))
        (result,) = await self._ask(self._client.uaclient.call([request]))
        return result

    async def children(self, nodes: Sequence[ua.NodeId], *, properties: bool = False) -> list[list[Child]]:
        """What lies below each node: objects and variables, and with ``properties`` what belongs to items."""
        return [self._relevant(found, properties) for found in await self._browse(nodes)]

    def roots(self) -> ua.NodeId:
        """The node that everything hangs under."""
        return ua.NodeId(ua.Int32(ObjectIds.ObjectsFolder), ua.Int16(0))

    def _relevant(self, found: list[Child], properties: bool) -> list[Child]:
        if self.items is not None:
            ours = (self.items, self.system) if properties else (self.items,)
            return [
                child for child in found if child.NodeId.NamespaceIndex in ours or (properties and is_property(child))
            ]
        return [
            child
            for child in found
            if (child.NodeId.NamespaceIndex != 0 or child.NodeId.Identifier not in _OF_EVERY_SERVER)
            and (properties or not is_property(child))
        ]

    async def _browse(self, nodes: Sequence[ua.NodeId]) -> list[list[Child]]:
        found: list[list[Child]] = []
        for some in _batches(nodes, MAX_NODES // 10):
            answers = await self._ask(self._client.uaclient.browse(_below(some)))
            found += [await self._rest(node, answer) for node, answer in zip(some, answers, strict=True)]
        return found

    async def _rest(self, node: ua.NodeId, answer: ua.BrowseResult) -> list[Child]:
        """All references, whether they came in one piece, in several, or not yet for want of room on the server."""
        if answer.StatusCode.value == StatusCodes.BadNoContinuationPoints:
            (answer,) = await self._ask(self._client.uaclient.browse(_below([node])))
        references = list(answer.References or [])
        while answer.ContinuationPoint:
            more = ua.BrowseNextParameters(
                ReleaseContinuationPoints=False, ContinuationPoints=[answer.ContinuationPoint]
            )
            (answer,) = await self._ask(self._client.uaclient.browse_next(more))
            if answer.StatusCode.value:
                raise Failed(f"{self.url} does not list all of {self.name(node)}: {_said(answer)}")
            references += answer.References or []
        return references

    # ------------------------------------------------------------------ changes

    async def subscribe(self, nodes: Sequence[ua.NodeId], interval: float) -> list[int]:
        """Ask to be told of changes, ``interval`` seconds apart; the StatusCode of each node.

        The handle of a node's changes is its place in ``nodes``. The first change is what the value is now.
        """
        milliseconds = interval * 1000
        params = ua.CreateSubscriptionParameters(
            RequestedPublishingInterval=ua.Duration(milliseconds),
            RequestedLifetimeCount=ua.Counter(max(30, round(60 / interval))),
            RequestedMaxKeepAliveCount=ua.Counter(max(10, round(5 / interval))),
            MaxNotificationsPerPublish=ua.Counter(0),
            PublishingEnabled=True,
        )
        made = await self._ask(self._client.uaclient.create_subscription(params, self._published))
        statuses: list[int] = []
        for some in _batches(enumerate(nodes), MAX_NODES):
            requests = [
                ua.MonitoredItemCreateRequest(
                    ua.ReadValueId(NodeId=node, AttributeId=VALUE),
                    ua.MonitoringMode.Reporting,
                    ua.MonitoringParameters(
                        ClientHandle=ua.IntegerId(handle),
                        SamplingInterval=ua.Duration(milliseconds),
                        QueueSize=ua.Counter(1),
                        DiscardOldest=True,
                    ),
                )
                for handle, node in some
            ]
            items = ua.CreateMonitoredItemsParameters(made.SubscriptionId, ua.TimestampsToReturn.Both, requests)
            results = await self._ask(self._client.uaclient.create_monitored_items(items))
            statuses += [int(result.StatusCode.value) for result in results]
        return statuses

    async def _published(self, result: ua.PublishResult) -> None:
        changes: list[Change] = []
        for notification in result.NotificationMessage.NotificationData or []:
            if isinstance(notification, ua.DataChangeNotification):
                changes += [(int(item.ClientHandle), item.Value) for item in notification.MonitoredItems]
            elif isinstance(notification, ua.StatusChangeNotification):
                self._changes.put_nowait(None)
        if changes:
            self._changes.put_nowait(changes)

    async def changes(self) -> list[Change]:
        """What changed since the last call; waits for it. Raises Lost when nothing can come any more."""
        some = await self._changes.get()
        if some is None:
            raise Lost(f"the connection to {self.url} was lost")
        return some


Child = ua.ReferenceDescription


@asynccontextmanager
async def connect(url: str, patience: float = PATIENCE) -> AsyncIterator[Remote]:
    """A session for the time of the block; ``patience`` in seconds bounds every answer."""
    logging.getLogger("asyncua").setLevel(logging.CRITICAL + 1)  # what it has to say, Failed says
    # asyncua gives a server that is busy with a large answer one second to say that it is alive.
    client = Client(url, timeout=patience, watchdog_intervall=patience)
    client.name = client.description = "pcaccess"
    client.application_uri = "urn:pcaccess:client"
    try:
        namespaces = await _reaching(url, patience, _namespaces(client))
        yield Remote(client, url, patience, namespaces)
    finally:
        await client.disconnect()


async def _namespaces(client: Client) -> list[str]:
    await client.connect()
    return await client.get_namespace_array()


async def _reaching(url: str, patience: float, attempt: Awaitable[T]) -> T:
    advice = "start one with: pcaccess run (or name another with --url)"
    try:
        return await attempt
    except TimeoutError:
        raise Failed(f"nothing at {url} answered like an OPC UA server within {patience:g} s; {advice}") from None
    except OSError as error:
        raise Failed(f"no server at {url} ({_reason(error)}); {advice}") from None
    except UaStatusCodeError as error:
        raise Failed(f"{url} refused the session: {status_text(int(error.code))}") from None
    except UaError as error:
        raise Failed(f"{url}: {error}") from None


def _reason(error: OSError) -> str:
    """In the system's words; asyncio has its own for a refused connection."""
    if error.errno is None or error.errno <= 0 or isinstance(error, socket.gaierror):
        return str(error.strerror or error)
    return os.strerror(error.errno)


# ---------------------------------------------------------------------- status codes


def status_name(status: int) -> str:
    """``BadNotConnected``; limit bits and other additions are left out."""
    name, _ = get_name_and_doc(status & 0xFFFF0000)
    return str(name)


_WORDS: Final = {
    StatusCodes.BadNodeIdUnknown: "there is no such item",
    StatusCodes.BadNodeIdInvalid: "this is no name of an item",
    StatusCodes.BadNotReadable: "the item can only be written",
    StatusCodes.BadNotWritable: "the item can only be read",
    StatusCodes.BadTypeMismatch: "the value does not have the item's type",
    StatusCodes.BadOutOfRange: "the value is outside what the item takes",
    StatusCodes.BadNotConnected: "the PLC is not connected",
    StatusCodes.BadNoCommunication: "the PLC does not answer",
    StatusCodes.BadDeviceFailure: "the PLC reports a failure",
    StatusCodes.BadConfigurationError: "the PLC does not have what the item names",
}


def status_text(status: int) -> str:
    """``BadNotWritable: the item can only be read``."""
    name, words = get_name_and_doc(status & 0xFFFF0000)
    return f"{name}: {_WORDS.get(status & 0xFFFF0000, str(words).rstrip('.'))}"


# ---------------------------------------------------------------------- helpers


def _index(namespaces: Sequence[str], uri: str) -> int | None:
    return namespaces.index(uri) if uri in namespaces else None


def is_property(child: Child) -> bool:
    return bool(child.ReferenceTypeId.Identifier == ObjectIds.HasProperty and child.ReferenceTypeId.NamespaceIndex == 0)


def _below(nodes: Sequence[ua.NodeId]) -> ua.BrowseParameters:
    """Objects and variables that hang under each node."""
    hierarchical = ua.NodeId(ua.Int32(ObjectIds.HierarchicalReferences), ua.Int16(0))
    return ua.BrowseParameters(
        NodesToBrowse=[
            ua.BrowseDescription(
                NodeId=node,
                BrowseDirection=ua.BrowseDirection.Forward,
                ReferenceTypeId=hierarchical,
                IncludeSubtypes=True,
                NodeClassMask=ua.UInt32(ua.NodeClass.Object | ua.NodeClass.Variable),
                ResultMask=ua.UInt32(ua.BrowseResultMask.All),
            )
            for node in nodes
        ]
    )


def _said(answer: ua.BrowseResult) -> str:
    return status_text(int(answer.StatusCode.value))


def _batches(values: Iterable[T], size: int) -> Iterator[list[T]]:
    iterator = iter(values)
    while batch := list(islice(iterator, size)):
        yield batch
