"""Links, PLCs, ports and groups of the project file: what each kind has, and what must be unique."""

from __future__ import annotations

from pathlib import Path

import pytest

from pcaccess.problems import ProblemError
from pcaccess.project.load import load_text
from pcaccess.project.model import Link, LinkType, Parity, Plc, Protocol, SerialLine
from pcaccess.s7200.address import parse_address


def link(text: str) -> Link:
    (only,) = load_text(f"links: [{{name: L, {text}}}]").project.links
    return only


def plc(link_text: str, plc_text: str) -> Plc:
    (only,) = link(f"{link_text}, plcs: [{{name: P, {plc_text}}}]").plcs
    return only


def told(text: str, base: Path | None = None) -> list[str]:
    """Code and message of everything that is wrong or, where nothing is, doubtful."""
    try:
        problems = list(load_text(text, base=base).warnings)
    except ProblemError as error:
        problems = [problem for problem in error.problems if problem.is_error]
    return [f"{problem.code} {problem.message}" for problem in problems]


def soft(plcs: str) -> str:
    return f"links: [{{name: L, type: soft, plcs: [{plcs}]}}]"


# -- what each kind has --------------------------------------------------------------------------------------------


def test_a_ppi_link_has_a_serial_line_and_our_own_address() -> None:
    found = link("type: ppi, port: socket://192.0.2.7:4001, baud: 19200, master: 1")
    assert (found.type, found.serial, found.master) == (
        LinkType.PPI,
        SerialLine("socket://192.0.2.7:4001", 19200, Parity.EVEN),
        1,
    )


@pytest.mark.parametrize("kind", ["modbus-rtu", "modbus-ascii"])
def test_a_serial_modbus_link_has_a_parity(kind: str) -> None:
    assert link(f"type: {kind}, port: COM3, parity: None").serial == SerialLine("COM3", 9600, Parity.NONE)


def test_a_plc_behind_a_cp_243_has_host_and_tsaps_and_they_stand_in_its_run_time_names() -> None:
    found = plc("type: s7tcp", "host: 192.0.2.5, port: 1102, local_tsap: 10.00, remote_tsap: '0301'")
    assert (found.host, found.port, found.local_tsap, found.remote_tsap) == ("192.0.2.5", 1102, 0x1000, 0x0301)
    assert found.station == "L:2:192.0.2.5:1000:0301"


def test_a_modbus_plc_has_a_unit_and_a_place_for_its_holding_registers() -> None:
    found = plc("type: modbus-tcp", "host: meter-1.plant, unit: 7, hold_start: vb100")
    assert (found.host, found.port, found.unit, found.hold_start) == ("meter-1.plant", 502, 7, parse_address("VB100"))


def test_a_soft_plc_has_program_scan_process_and_ports(tmp_path: Path) -> None:
    (tmp_path / "p.awl").write_text("")
    text = soft(
        "{name: P, generation: 1, cpu: 224, program: p.awl, scan: 5ms, process: one,"
        " ports: [{protocol: S7, listen: '127.0.0.1:10102'}, {protocol: modbus-rtu, listen: COM9, unit: 3}]}"
    )
    (found,) = load_text(text, base=tmp_path).project.all_plcs()
    assert (found.cpu.name, found.cpu.generation) == ("CPU 224", 1)
    assert (found.program, found.scan, found.process) == (tmp_path / "p.awl", 0.005, "one")
    assert [(port.protocol, port.listen, port.unit) for port in found.ports] == [
        (Protocol.S7, "127.0.0.1:10102", 1),
        (Protocol.MODBUS_RTU, "COM9", 3),
    ]


def test_a_free_scan_has_no_interval() -> None:
    assert plc("type: soft", "program: p.awl, scan: free").scan is None
    assert plc("type: soft", "program: p.awl").scan == 0.010


def test_descriptions_are_kept_everywhere() -> None:
    text = (
        "links: [{name: L, type: soft, description: a, plcs: [{name: P, description: b,"
        " folders: [{name: F, description: c}]}]}]\ngroups: [{name: G, description: d}]"
    )
    project = load_text(text).project
    (found,) = project.all_plcs()
    assert [project.links[0].description, found.description, found.folders[0].description] == ["a", "b", "c"]
    assert project.groups[0].description == "d"


def test_folders_nest_and_items_come_before_the_folders_beside_them() -> None:
    text = soft(
        "{name: P, folders: [{name: A, folders: [{name: B, items: [{name: z, address: VB0}]}],"
        " items: [{name: y, address: VB1}]}], items: [{name: x, address: VB2}]}"
    )
    assert [item.item_id for item in load_text(text).project.all_items()] == ["L.P.x", "L.P.A.y", "L.P.A.B.z"]


def test_links_plcs_and_items_are_found_in_any_case() -> None:
    project = load_text(soft("{name: P, items: [{name: Motor, address: Q0.0}]}")).project
    assert project.link("l") is project.links[0]
    assert project.plc("l.p") is project.links[0].plcs[0]
    assert project.link("x") is project.plc("L.x") is None
    assert project.items_by_id()["l.p.motor"].name == "Motor"


def test_groups_name_items_in_any_case_and_get_them_as_written() -> None:
    text = soft("{name: P, items: [{name: A, address: Q0.0}]}") + (
        "\ngroups: [{name: G, update_rate: 2min, active: no, dead_band: 2.5, items: [l.p.a]}]"
    )
    (group,) = load_text(text).project.groups
    assert (group.update_rate, group.active, group.dead_band, group.items) == (120.0, False, 2.5, ("L.P.A",))


def test_what_the_server_is_told_is_kept() -> None:
    text = (
        "links: []\nserver: {endpoint: 'opc.tcp://localhost:0/x', read_timeout: 500ms}\n"
        "dynamic_items: {access: R, max: 0, idle: 1h}"
    )
    project = load_text(text).project
    assert (project.server.endpoint, project.server.read_timeout) == ("opc.tcp://localhost:0/x", 0.5)
    assert (str(project.dynamic_items.access), project.dynamic_items.max, project.dynamic_items.idle) == ("R", 0, 3600)


# -- what must be unique -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (soft("{name: A, address: 3}, {name: B, address: 3}"), "PRJ016 two PLCs of L have address 3"),
        (
            "links: [{name: L, type: s7tcp, plcs: [{name: A, host: h}, {name: B, host: H}]}]",
            "PRJ016 two PLCs of L have the same address, host and TSAPs (L:2:H:1000:1001)",
        ),
        (
            "links: [{name: L, type: modbus-rtu, port: COM1, plcs: [{name: A, unit: 4}, {name: B, unit: 4}]}]",
            "PRJ016 two PLCs of L have unit 4",
        ),
        (soft("{name: A}, {name: a}"), "PRJ015 there are two of L.a; case makes no difference"),
        (
            soft("{name: A, items: [{name: x, address: VB0}], folders: [{name: X}]}"),
            "PRJ015 there are two of L.A.X; case makes no difference",
        ),
        ("links: [{name: A, type: soft}, {name: a, type: sim}]", "PRJ015 there are two of a; case makes no difference"),
        ("links: []\ngroups: [{name: A}, {name: a}]", "PRJ015 there are two groups a; case makes no difference"),
    ],
)
def test_two_of_one_kind_are_told_at_the_second(text: str, message: str) -> None:
    assert told(text) == [message]


def test_the_first_of_two_is_named_with_its_place() -> None:
    with pytest.raises(ProblemError) as caught:
        load_text("links:\n  - {name: A, type: soft}\n  - {name: A, type: soft}\n")
    (problem,) = caught.value.problems
    assert [f"{span} {words}" for span, words in problem.related] == ["items.yaml:2:12 first used here"]


def test_several_plcs_may_stand_behind_one_cp_243_with_other_tsaps() -> None:
    plcs = "{name: A, host: h}, {name: B, host: h, remote_tsap: 11.01}, {name: C, host: h, port: 1102}"
    assert told(f"links: [{{name: L, type: s7tcp, plcs: [{plcs}]}}]") == []


# -- what cannot be -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["a.b", "a,b", "a:b", "a/b", " a", "a ", "", "a\\tb", "x" * 256])
def test_a_name_that_would_break_item_ids_is_refused(name: str) -> None:
    assert [line[:6] for line in told(soft(f'{{name: "{name}", items: [{{name: A, address: VB0}}]}}'))] == ["PRJ014"]
    assert [line[:6] for line in told(f'links: []\ngroups: [{{name: "{name}"}}]')] == ["PRJ014"]


def test_a_link_cannot_take_the_place_of_the_groups() -> None:
    (line,) = told("links: [{name: groups, type: soft}]")
    assert line.startswith("PRJ014 a link cannot be called Groups")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (soft("{name: P, cpu: CPU 223}"), "PRJ020 cpu: there is no 'CPU 223'; the models are"),
        (soft("{name: P, cpu: CPU 224XP, generation: 1}"), "PRJ020 generation: CPU 224XP exists only in generation 2"),
        (soft("{name: P, generation: 3}"), "PRJ012 generation: '3' is out of range"),
        (soft("{name: P, address: 127}"), "PRJ012 address: '127' is out of range"),
        (soft("{name: P, address: two}"), "PRJ010 address: 'two'"),
        (soft("{name: P, connected: maybe}"), "PRJ010 connected: 'maybe'"),
        (soft("{name: P, scan: 10ms}"), "PRJ025 scan: only a PLC with a program has it"),
        (soft("{name: P, process: x}"), "PRJ025 process: only a PLC with a program has it"),
        (soft("{name: P, program: p.awl, scan: 10}"), "PRJ013 scan: 10 has no unit; write 10ms or 10s"),
        (soft("{name: P, program: p.awl, scan: 0ms}"), "PRJ013 scan: the time must be longer than nothing"),
        (soft("{name: P, write_limits: refused}"), "PRJ011 there are no write limits 'refused'"),
        (soft("{name: P, ports: [{protocol: s8, listen: x}]}"), "PRJ011 protocol: there is no 's8'"),
        (soft("{name: P, ports: [{protocol: s7, listen: '10102'}]}"), "PRJ028 listen: '10102'"),
        (soft("{name: P, ports: [{protocol: s7, listen: 'h:99999'}]}"), "PRJ028 listen: 'h:99999'"),
        (soft("{name: P, ports: [{protocol: ppi, listen: 'socket://h'}]}"), "PRJ028 listen: 'socket://h'"),
        (soft("{name: P, ports: [{protocol: s7, listen: 'h:1', host: h}]}"), "PRJ008 unknown key 'host'"),
        (soft("{name: P, ports: [{listen: x}]}"), "PRJ009 the key 'protocol' is missing"),
        ("links: [{name: L, type: ppi, plcs: []}]", "PRJ009 the key 'port' is missing"),
        ("links: [{name: L, type: ppi, port: x, plcs: [{name: P}]}]", "PRJ009 the key 'address' is missing"),
        ("links: [{name: L, type: ppi, port: x, baud: fast}]", "PRJ010 baud: 'fast'"),
        ("links: [{name: L, type: modbus-rtu, port: x, parity: mark}]", "PRJ011 parity: there is no 'mark'"),
        ("links: [{name: L, type: s7tcp, plcs: [{name: P, host: 'fe80::1'}]}]", "PRJ028 host: 'fe80::1' is not a host"),
        (
            "links: [{name: L, type: s7tcp, plcs: [{name: P, host: h, local_tsap: 10.0}]}]",
            "PRJ031 local_tsap: '10.0' is not a TSAP",
        ),
        (
            "links: [{name: L, type: modbus-tcp, plcs: [{name: P, host: h, hold_start: VW0}]}]",
            "PRJ017 hold_start: VW0 is not a V byte",
        ),
        (
            "links: [{name: L, type: modbus-tcp, plcs: [{name: P, host: h, hold_start: VB99999}]}]",
            "PRJ017 hold_start: VB99999: a CPU 226 has VB0 to VB10239",
        ),
        ("links: [{name: L, type: opcua, endpoint: other:4840}]", "PRJ028 endpoint: 'other:4840' is not an endpoint"),
        ("links: []\nserver: {endpoint: http://127.0.0.1:4840}", "PRJ028 endpoint: 'http://127.0.0.1:4840' is not an"),
        ("links: []\nserver: {endpoint: 'opc.tcp://127.0.0.1'}", "PRJ028 endpoint: 'opc.tcp://127.0.0.1' has no port"),
        ("links: []\nserver: {endpoint: 'opc.tcp://127.0.0.1:x'}", "PRJ028 endpoint: 'opc.tcp://127.0.0.1:x': Port"),
        (
            "links: []\nserver: {endpoint: 'opc.tcp://u@127.0.0.1:1'}",
            "PRJ028 endpoint: 'opc.tcp://u@127.0.0.1:1' has more",
        ),
        ("links: []\nserver: {endpoint: 'opc.tcp://[::1:4840'}", "PRJ028 endpoint: 'opc.tcp://[::1:4840'"),
        ("links: []\nserver: {read_timeout: soon}", "PRJ013 read_timeout: 'soon' is not a duration"),
        ("links: []\ndynamic_items: {access: none}", "PRJ011 there is no access 'none'"),
        ("links: []\ndynamic_items: {max: -1}", "PRJ012 max: '-1' is out of range"),
        ("links: []\ngroups: [{name: G, items: [L.P.A]}]", "PRJ029 there is no item L.P.A"),
        ("links: []\ngroups: [{name: G, items: [[a]]}]", "PRJ010 a list"),
        (
            "links: []\ngroups: [{name: G, update_rate: 5 parsecs}]",
            "PRJ013 update_rate: 'parsecs' is not a unit of time",
        ),
    ],
)
def test_a_value_that_cannot_be_is_told(text: str, message: str) -> None:
    (line,) = told(text)
    assert line.startswith(message)


def test_a_program_that_is_not_there_or_is_a_directory_is_told(tmp_path: Path) -> None:
    (tmp_path / "d").mkdir()
    assert told(soft("{name: P, program: p.awl}"), tmp_path) == ["PRJ001 program: there is no file p.awl"]
    assert told(soft("{name: P, program: d}"), tmp_path) == ["PRJ001 program: d is a directory"]
    assert told(soft("{name: P, program: ''}"), tmp_path) == ["PRJ001 program: this names no file"]


def test_an_unconnected_plc_with_items_is_a_warning_and_an_empty_one_is_not() -> None:
    items = "items: [{name: A, address: VB0}, {name: B, address: VB1}]"
    assert told(soft(f"{{name: P, connected: false, {items}}}")) == [
        "PRJ033 L.P is not connected, so its 2 items are NOT_CONNECTED"
    ]
    assert told(soft("{name: P, connected: false}")) == []


def test_an_item_that_is_wrong_is_known_to_the_groups_that_name_it() -> None:
    items = "items: [{name: A, address: XX}, {name: B, address: [1]}, {name: C, address: VB0, colour: red}]"
    text = soft(f"{{name: P, {items}}}") + "\ngroups: [{name: G, items: [L.P.A, L.P.B, L.P.C]}]"
    assert [line[:6] for line in told(text)] == ["PRJ017", "PRJ010", "PRJ008"]


def test_a_mistake_in_something_used_twice_by_alias_is_told_once() -> None:
    text = (
        "links:\n  - name: L\n    type: soft\n    plcs:\n"
        "      - {name: P, items: &same [{name: A, address: XX}, {name: B, address: VB0, colour: red}]}\n"
        "      - {name: Q, items: *same}\n"
    )
    assert [line[:6] for line in told(text)] == ["PRJ017", "PRJ008"]


def test_hints_for_unknown_items_stop_when_they_are_many() -> None:
    unknown = ", ".join(f"L.P.Motr{n}" for n in range(30))
    text = soft("{name: P, items: [{name: Motor, address: VB0}]}") + f"\ngroups: [{{name: G, items: [{unknown}]}}]"
    with pytest.raises(ProblemError) as caught:
        load_text(text)
    assert sum(problem.nearest == "L.P.Motor" for problem in caught.value.problems) == 20
