"""Requests of one connection on asyncua's own path: whose they are, and the services asyncua has not got.

Mended here (docs/decisions/2026-11-22-asyncua.md): a request's AuthenticationToken was not compared with its session's;
a session could be used from two channels, and activated by another certificate than the one that made it; sessions made
again and again were never forgotten; BrowseNext failed and RegisterNodes did nothing; each refused request was an error
in the log, so that a client that went on asking in a session that had ended filled it.

Source:   OPC UA Part 4, 5.6.2 CreateSession, 5.6.3 ActivateSession, 5.8 View service set.
"""

from __future__ import annotations

import logging
from collections.abc import Awaitable, Callable
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from asyncua import ua
from asyncua.common.utils import ServiceError
from asyncua.server.uaprocessor import UaProcessor
from asyncua.ua.object_ids import ObjectIdNames, ObjectIds
from asyncua.ua.status_codes import StatusCodes
from asyncua.ua.ua_binary import nodeid_from_binary, struct_from_binary
from asyncua.ua.uaerrors import UaStatusCodeError

from pcaccess.opcua.ids import standard
from pcaccess.opcua.sessions import Session

if TYPE_CHECKING:
    from pcaccess.opcua.asyncua_server import Internal

log = logging.getLogger(__name__)

_CREATE_SESSION: Final = standard(ObjectIds.CreateSessionRequest_Encoding_DefaultBinary)
_ACTIVATE_SESSION: Final = standard(ObjectIds.ActivateSessionRequest_Encoding_DefaultBinary)
_CLOSE_SESSION: Final = standard(ObjectIds.CloseSessionRequest_Encoding_DefaultBinary)
_SESSIONLESS: Final = frozenset(
    standard(number)
    for number in (
        ObjectIds.FindServersRequest_Encoding_DefaultBinary,
        ObjectIds.GetEndpointsRequest_Encoding_DefaultBinary,
        ObjectIds.RegisterServerRequest_Encoding_DefaultBinary,
        ObjectIds.RegisterServer2Request_Encoding_DefaultBinary,
        ObjectIds.CloseSecureChannelRequest_Encoding_DefaultBinary,
    )
)
"""Services that carry no AuthenticationToken."""


class Processor(UaProcessor):
    """asyncua's processor behind our checks."""

    iserver: Internal
    session: Session | None

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._told: set[tuple[str, str]] = set()

    async def process_message(self, seqhdr: Any, body: Any) -> Any:
        """Answer one request, with a fault if nothing else; False ends the connection."""
        typeid = nodeid_from_binary(body)
        requesthdr = struct_from_binary(ua.RequestHeader, body)
        try:
            return await self._process_message(typeid, requesthdr, seqhdr, body)
        except (ServiceError, UaStatusCodeError) as error:
            code = int(error.code)
            self._tell(typeid, ua.StatusCode(ua.UInt32(code)).name, logging.INFO)
        except Exception as error:
            code = StatusCodes.BadInternalError
            self._tell(typeid, f"BadInternalError ({type(error).__name__})", logging.ERROR, error)
        fault = ua.ServiceFault()
        fault.ResponseHeader.ServiceResult = ua.StatusCode(ua.UInt32(code))
        self.send_response(requesthdr.RequestHandle, seqhdr, fault)
        return True

    def _tell(self, typeid: ua.NodeId, why: str, level: int, error: Exception | None = None) -> None:
        """Log a refused request: the first of its kind on this connection, others for debugging only."""
        number = typeid.Identifier if isinstance(typeid.Identifier, int) else -1
        service = ObjectIdNames.get(number, "a service nobody knows").removesuffix("_Encoding_DefaultBinary")
        if (service, why) in self._told:
            level, error = logging.DEBUG, None
        self._told.add((service, why))
        log.log(level, "%s of %s is answered with %s", service, self.name, why, exc_info=error)

    async def _process_message(self, typeid: Any, requesthdr: Any, seqhdr: Any, body: Any) -> Any:
        if typeid in _SESSIONLESS:
            return await super()._process_message(typeid, requesthdr, seqhdr, body)
        if typeid == _CREATE_SESSION:
            return await self._create_session(typeid, requesthdr, seqhdr, body)
        if typeid == _ACTIVATE_SESSION:
            return await self._activate_session(typeid, requesthdr, seqhdr, body)
        session = self._own_session(requesthdr.AuthenticationToken)
        if typeid != _CLOSE_SESSION and not session.is_activated():
            raise ServiceError(StatusCodes.BadSessionNotActivated)
        if typeid == _CLOSE_SESSION or session.channel is self:
            service = _SERVICES.get(typeid)
            if service is None:
                return await super()._process_message(typeid, requesthdr, seqhdr, body)
            self._check_permission(session, typeid, body)
            self.touch(session)
            self.send_response(requesthdr.RequestHandle, seqhdr, await service(session, body))
            return True
        raise ServiceError(StatusCodes.BadSecureChannelIdInvalid)

    def _own_session(self, token: ua.NodeId) -> Session:
        """The session of this channel, if the token is its own."""
        session = self.session
        if session is None or token != session.auth_token or session.is_closed:
            raise ServiceError(StatusCodes.BadSessionIdInvalid)
        return session

    def _check_permission(self, session: Session, typeid: Any, body: Any) -> None:
        rules = self._connection.security_policy.permissions
        if rules is not None and rules.check_validity(session.user, _ALLOWED_LIKE.get(typeid, typeid), body) is False:
            raise ServiceError(StatusCodes.BadUserAccessDenied)

    def touch(self, session: Session) -> None:
        """The session is in use: its time begins again."""
        session.touch()
        self.session_last_activity = session._last_activity

    async def _create_session(self, typeid: Any, requesthdr: Any, seqhdr: Any, body: Any) -> Any:
        """A channel has one session here: the next one ends it."""
        if self.session is not None and self.session.channel in (None, self):
            await self.session.close_session(True)
        answer = await super()._process_message(typeid, requesthdr, seqhdr, body)
        if self.session is not None:
            self.session.certificate = self._connection.security_policy.peer_certificate
        return answer

    async def _activate_session(self, typeid: Any, requesthdr: Any, seqhdr: Any, body: Any) -> Any:
        """The session moves to this channel, if its maker asks."""
        token = requesthdr.AuthenticationToken
        session = self._own_session(token) if self.session is not None else self.iserver.session_of(token)
        if session is None:
            raise ServiceError(StatusCodes.BadSessionIdInvalid)
        if session.certificate != self._connection.security_policy.peer_certificate:
            raise ServiceError(StatusCodes.BadSecurityChecksFailed)
        answer = await super()._process_message(typeid, requesthdr, seqhdr, body)
        session.channel = self
        return answer

    def _should_close_session_on_transport_loss(self) -> bool:
        """Not when the session went on to another channel."""
        if self.session is not None and self.session.channel not in (None, self):
            return False
        return bool(super()._should_close_session_on_transport_loss())


async def _browse_next(session: Session, body: Any) -> ua.BrowseNextResponse:
    results = await session.browse_next(struct_from_binary(ua.BrowseNextParameters, body))
    return ua.BrowseNextResponse(Parameters=ua.BrowseNextResult(Results=results))


async def _register_nodes(session: Session, body: Any) -> ua.RegisterNodesResponse:
    nodes = struct_from_binary(ua.RegisterNodesParameters, body).NodesToRegister
    return ua.RegisterNodesResponse(Parameters=ua.RegisterNodesResult(await session.register_nodes(nodes)))


async def _unregister_nodes(session: Session, body: Any) -> ua.UnregisterNodesResponse:
    await session.unregister_nodes(struct_from_binary(ua.UnregisterNodesParameters, body).NodesToUnregister)
    return ua.UnregisterNodesResponse()


_ALLOWED_LIKE: Final = MappingProxyType[ua.NodeId, ua.NodeId](
    {
        standard(ObjectIds.BrowseNextRequest_Encoding_DefaultBinary): standard(
            ObjectIds.BrowseRequest_Encoding_DefaultBinary
        )
    }
)
"""Services that asyncua's rules do not know, because it does not have them."""

_SERVICES: Final = MappingProxyType[ua.NodeId, Callable[[Session, Any], Awaitable[Any]]](
    {
        standard(ObjectIds.BrowseNextRequest_Encoding_DefaultBinary): _browse_next,
        standard(ObjectIds.RegisterNodesRequest_Encoding_DefaultBinary): _register_nodes,
        standard(ObjectIds.UnregisterNodesRequest_Encoding_DefaultBinary): _unregister_nodes,
    }
)
