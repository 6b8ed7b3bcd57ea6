"""Every internal of asyncua that this package overrides, calls or reads, so that it fails in one place.

``tests/opcua/test_asyncua_contract.py`` checks each name and what we rely on of it; the range of asyncua in
``pyproject.toml`` is what those tests passed on.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from asyncua.common.connection import MessageChunk, SecureConnection, TransportLimits
from asyncua.crypto.security_policies import Cryptography, CryptographyNone
from asyncua.server.address_space import AddressSpace, AttributeService, NodeData, ViewService
from asyncua.server.binary_server_asyncio import BinaryServer, OPCUAProtocol
from asyncua.server.internal_server import InternalServer
from asyncua.server.internal_session import InternalSession
from asyncua.server.internal_subscription import InternalSubscription
from asyncua.server.monitored_item_service import MonitoredItemService
from asyncua.server.server import Server
from asyncua.server.subscription_service import SubscriptionService
from asyncua.server.uaprocessor import UaProcessor

OVERRIDDEN: Final = MappingProxyType(
    {
        InternalServer: "create_session stop",
        InternalSession: (
            "read write call browse browse_next translate_browsepaths_to_nodeids register_nodes unregister_nodes "
            "create_monitored_items modify_monitored_items delete_monitored_items set_monitoring_mode "
            "modify_subscription set_publishing_mode delete_subscriptions publish republish transfer_subscriptions"
        ),
        AttributeService: "write",
        ViewService: "_suitable_reftype",
        SubscriptionService: "create_subscription modify_subscription",
        InternalSubscription: "has_published_results _subscription_loop",
        MonitoredItemService: (
            "create_monitored_items _create_data_change_monitored_item _modify_monitored_item _set_monitoring_mode "
            "_delete_monitored_items delete_all_monitored_items"
        ),
        UaProcessor: "process_message _process_message _should_close_session_on_transport_loss",
        OPCUAProtocol: "connection_made connection_lost data_received _process_received_message_loop",
        BinaryServer: "_make_protocol",
        TransportLimits: "create_acknowledge_and_set_limits",
    }
)
"""Methods that asyncua calls and our subclasses replace."""

CALLED: Final = MappingProxyType(
    {
        InternalServer: "lookup_external_session register_external_session unregister_external_session",
        InternalSession: "touch is_activated close_session activate_session",
        AddressSpace: "read_attribute_value",
        ViewService: "_suitable_direction",
        SubscriptionService: "_clamp_lifetime_count _clamp_keep_alive_count",
        UaProcessor: "set_policies send_response process",
        OPCUAProtocol: "_process_one_msg",
        BinaryServer: "start stop",
        Server: (
            "_setup_server_nodes register_namespace set_build_info set_endpoint set_security_policy load_certificate "
            "load_private_key init stop"
        ),
        MessageChunk: "max_body_size",
        Cryptography: (
            "decrypt verify remove_padding vsignature_size padding signature_size plain_block_size "
            "encrypted_block_size signature encrypt use_prev_key"
        ),
        CryptographyNone: "signature_size min_padding_size plain_block_size encrypted_block_size",
    }
)
"""Methods that our code calls."""

ATTRIBUTES: Final = MappingProxyType(
    {
        InternalServer: (
            "aspace attribute_service view_service subscription_service isession max_connections supported_tokens "
            "allow_remote_admin time_task max_subscriptions"
        ),
        InternalSession: "auth_token session_id state user external iserver _last_activity subscription_service",
        AddressSpace: "_nodes",
        NodeData: "attributes references call",
        SubscriptionService: "subscriptions _sub_id_counter iserver aspace",
        InternalSubscription: (
            "data monitored_item_srv session_id _triggered_datachanges _not_acknowledged_results _publishing_enabled "
            "_closing"
        ),
        MonitoredItemService: "aspace isub _monitored_items _monitored_item_counter",
        UaProcessor: "session session_last_activity _connection _limits",
        OPCUAProtocol: "processor transport messages iserver limits peer_name policies",
        BinaryServer: "iserver clients closing_tasks limits _policies port",
        Server: "bserver endpoint _policies limits",
        SecureConnection: (
            "_sequence_number _peer_sequence_number _incoming_parts _incoming_size _limits security_policy "
            "security_token"
        ),
        TransportLimits: "max_recv_buffer max_send_buffer max_chunk_count max_message_size",
    }
)
"""Attributes of their objects that our code reads or sets."""
