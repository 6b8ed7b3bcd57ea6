"""The JSON Schema that editors use."""

from __future__ import annotations

from typing import Any

import jsonschema
import pytest
import yaml

from pcaccess.project.load import load_text
from pcaccess.project.schema import project_schema

SCHEMA = jsonschema.Draft202012Validator(project_schema())

SAMPLE = """
# yaml-language-server: $schema=./items.schema.json
project: Bottling line
server: {endpoint: opc.tcp://127.0.0.1:4840/pcaccess, read_timeout: 2s}
dynamic_items: {access: RW, max: 10000, idle: 10min}
links:
  - name: MicroWin
    type: soft
    plcs:
      - name: NewPLC
        address: 2
        cpu: CPU 224
        connected: true
        scan: free
        process: one
        program: traffic.awl
        write_limits: refuse
        ports:
          - {protocol: ppi, listen: "socket://127.0.0.1:10200"}
          - {protocol: modbus-rtu, listen: /dev/ttyS1, baud: 9600, parity: even, unit: 1}
        items:
          - {name: Temperature, address: VW0, type: INT, access: RW, high: 1000, low: 200, unit: °C, description: Oven}
          - {name: Pressure, address: AIW0, access: R, scaling: {raw: [0, 32000], scaled: [0, 10], clamp: true}}
          - {name: Text, address: VB100, type: STRING, length: 32}
        folders:
          - {name: USR1, items: [{name: COUNTER_1, address: VW0, type: INT}]}
  - {name: Line1, type: ppi, port: /dev/ttyUSB0, baud: 19200, master: 0, plcs: [{name: Press, address: 2}]}
  - {name: Eth, type: s7tcp, plcs: [{name: Oven, host: 192.0.2.5, port: 102, local_tsap: "10.00", remote_tsap: 10.01}]}
  - {name: Bus, type: modbus-tcp, plcs: [{name: Meter, host: 192.0.2.9, unit: 1, hold_start: VB0}]}
  - name: Up
    type: opcua
    endpoint: opc.tcp://other:4840
    plcs: [{name: Site2, items: [{name: T1, address: "ns=2;s=A.B.T1", type: REAL}]}]
  - {name: Sim, type: sim, plcs: [{name: Demo, items: [{name: Wave, address: "SINE(10s, 0, 100)", type: REAL}]}]}
groups:
  - {name: Fast, update_rate: 250ms, active: true, dead_band: 1.5, items: [MicroWin.NewPLC.Temperature]}
"""


def complaints(text: str) -> list[str]:
    data: Any = yaml.safe_load(text)
    return [f"{error.json_path}: {error.message}" for error in SCHEMA.iter_errors(data)]


def test_the_schema_is_a_schema() -> None:
    jsonschema.Draft202012Validator.check_schema(project_schema())


def test_what_the_loader_takes_the_schema_takes() -> None:
    load_text(SAMPLE)
    assert complaints(SAMPLE) == []


@pytest.mark.parametrize(
    ("wrong", "place"),
    [
        ("links: []\nserver: {endpont: x}", "$.server"),
        ("project: x", "$"),
        ("links: [{name: L, type: sotf}]", "$.links[0]"),
        ("links: []\ngroups: [{name: G, update_rate: 250}]", "$.groups[0].update_rate"),
        ("links: []\ngroups: [{name: G, dead_band: 101}]", "$.groups[0].dead_band"),
    ],
)
def test_the_schema_refuses_what_the_loader_refuses(wrong: str, place: str) -> None:
    with pytest.raises(Exception, match="PRJ"):
        load_text(wrong)
    assert [line.split(":")[0] for line in complaints(wrong)] == [place]


def test_every_key_has_a_description_for_the_editor() -> None:
    schema = project_schema()
    shapes = {"project": schema, **schema["$defs"]}
    silent = [
        f"{shape}.{key}"
        for shape, content in shapes.items()
        for key, value in content.get("properties", {}).items()
        if "description" not in value and "$ref" not in value and "const" not in value
    ]
    assert silent == []


def test_nothing_of_pydantic_shows() -> None:
    text = str(project_schema())
    assert "'null'" not in text
    assert "None" not in text
