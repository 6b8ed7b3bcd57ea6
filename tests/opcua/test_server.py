"""Where and as whom the server listens."""

from __future__ import annotations

from pathlib import Path

import pytest

from pcaccess.opcua.server import EndpointError, Identity, OpcUaServer
from tests.gateways import start_gateway
from tests.opcua.conftest import PLANT


@pytest.mark.parametrize("content", [None, "no certificate"])
async def test_an_identity_that_cannot_be_read_says_which_file(tmp_path: Path, content: str | None) -> None:
    """A good one is in the differential tests, which read and write over it."""
    certificate = tmp_path / "own.der"
    if content is not None:
        certificate.write_text(content)
    async with start_gateway(PLANT) as running:
        server = OpcUaServer(running.gateway, "opc.tcp://127.0.0.1:0/x", Identity(certificate, tmp_path / "own.pem"))
        with pytest.raises(EndpointError, match=r"own\.der cannot be used as the server's certificate"):
            await server.start()
        await server.stop()
