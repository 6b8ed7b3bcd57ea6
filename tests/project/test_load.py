"""items.yaml to a project: what is read, what is refused and where."""

from __future__ import annotations

from pathlib import Path

import pytest

from pcaccess.problems import ProblemError
from pcaccess.project.access import Access
from pcaccess.project.load import load_project, load_text
from pcaccess.project.model import Item, LinkType, Scaling, WriteLimits
from pcaccess.s7200.address import parse_address
from pcaccess.s7200.types import DataType


def soft(items: str, *, plc: str = "", groups: str = "") -> str:
    """A project with one soft PLC; ``items`` is a flow sequence without its brackets."""
    more = f", {plc}" if plc else ""
    return f"links: [{{name: L, type: soft, plcs: [{{name: P{more}, items: [{items}]}}]}}]\n{groups}"


def only_item(text: str) -> Item:
    (item,) = load_text(text).project.all_items()
    return item


def errors(text: str, base: Path | None = None) -> list[str]:
    """The lines a user sees."""
    with pytest.raises(ProblemError) as caught:
        load_text(text, base=base)
    return [str(problem) for problem in caught.value.problems]


def warnings(text: str) -> list[str]:
    return [str(problem) for problem in load_text(text).warnings]


# -- what is read --------------------------------------------------------------------------------------------------


def test_an_item_has_everything_its_line_says() -> None:
    item = only_item(
        soft("{name: Temp, address: vw0, type: int, access: RW, high: 1000, low: 200, unit: °C, description: Oven}")
    )
    assert item.item_id == "L.P.Temp"
    assert item.address == parse_address("VW0")
    assert (item.data_type, item.raw_type, item.access) == (DataType.INT, DataType.INT, Access.RW)
    assert (item.low, item.high, item.unit, item.description) == (200.0, 1000.0, "°C", "Oven")
    assert item.run_time_name == "L:2:0.0.0.0:0000:0000,VW0,INT,RW,1000.000,200.000"


@pytest.mark.parametrize(
    ("address", "data_type"),
    [
        ("Q0.0", "BOOL"),
        ("VB0", "BYTE"),
        ("VW0", "INT"),
        ("VD0", "DINT"),
        ("T37", "INT"),
        ("C5", "INT"),
        ("HC0", "DINT"),
    ],
)
def test_the_type_left_out_is_the_one_pc_access_gives_on_import(address: str, data_type: str) -> None:
    assert only_item(soft(f"{{name: A, address: {address}}}")).data_type.name == data_type


def test_a_scaled_item_is_real_over_a_signed_word() -> None:
    item = only_item(soft("{name: P, address: AIW0, scaling: {raw: [0, 32000], scaled: [0, 10], clamp: true}}"))
    assert (item.data_type, item.raw_type) == (DataType.REAL, DataType.INT)
    assert item.scaling == Scaling(0, 32000, 0, 10, clamp=True)


@pytest.mark.parametrize("address", ["HC0", "SM0.0", "SMW28"])
def test_what_the_hardware_alone_writes_is_read_only(address: str) -> None:
    assert only_item(soft(f"{{name: A, address: {address}}}")).access is Access.R


def test_limits_of_zero_are_no_limits() -> None:
    item = only_item(soft("{name: A, address: VW0, high: 0, low: 0}"))
    assert (item.low, item.high) == (None, None)


def test_write_limits_of_the_plc_hold_for_items_with_limits_and_the_item_may_say_otherwise() -> None:
    text = soft(
        "{name: A, address: VW0, high: 9, low: 1}, {name: B, address: VW2},"
        "{name: C, address: VW4, high: 9, low: 1, write_limits: clamp}",
        plc="write_limits: refuse",
    )
    found = [item.write_limits for item in load_text(text).project.all_items()]
    assert found == [WriteLimits.REFUSE, WriteLimits.NONE, WriteLimits.CLAMP]


@pytest.mark.parametrize("word", ["On", "no", "007", "0x10", "1_000", "2024-01-01"])
def test_a_name_is_what_stands_in_the_file(word: str) -> None:
    assert only_item(soft(f"{{name: {word}, address: VW0}}")).name == word


@pytest.mark.parametrize("word", ["1.10", "1:30", "yes", "~/x"])
def test_a_description_is_what_stands_in_the_file(word: str) -> None:
    assert only_item(soft(f"{{name: A, address: VW0, description: {word}}}")).description == word


def test_plcs_without_address_get_the_next_free_one_from_two_on() -> None:
    text = "links: [{name: L, type: soft, plcs: [{name: A}, {name: B, address: 3}, {name: C}]}]"
    assert [plc.address for plc in load_text(text).project.all_plcs()] == [2, 3, 4]


def test_merge_keys_and_aliases_share_what_items_have_in_common() -> None:
    text = (
        "links:\n  - name: L\n    type: soft\n    plcs:\n      - name: P\n        items:\n"
        "          - &a {name: A, address: VW0, high: 9, low: 1}\n"
        "          - {<<: *a, name: B, address: VW2}\n"
    )
    assert [item.high for item in load_text(text).project.all_items()] == [9, 9]


# -- what is refused -----------------------------------------------------------------------------------------------


def test_every_mistake_of_a_file_is_told_at_once_and_in_order() -> None:
    text = (
        "server: {endpont: x}\n"
        "links:\n"
        "  - name: L\n"
        "    type: soft\n"
        "    plcs:\n"
        "      - name: P\n"
        "        cpu: CPU 222\n"
        "        items:\n"
        "          - {name: A, address: VB6000}\n"
        "          - {name: a, address: VW0, type: FLOAT}\n"
        "          - {name: B, adress: V0}\n"
        "groups:\n"
        "  - {name: G, update_rate: 1s, items: [L.P.A, L.P.X]}\n"
    )
    places = [line.split(" ")[:2] for line in errors(text)]
    assert places == [
        ["items.yaml:1:10:", "PRJ008"],
        ["items.yaml:1:19:", "PRJ028"],
        ["items.yaml:9:32:", "PRJ018"],
        ["items.yaml:10:20:", "PRJ015"],
        ["items.yaml:10:43:", "PRJ011"],
        ["items.yaml:11:23:", "PRJ008"],
        ["items.yaml:11:31:", "PRJ017"],
        ["items.yaml:13:47:", "PRJ029"],
    ]


def test_an_address_beyond_the_cpu_says_what_it_has() -> None:
    (line,) = errors(soft("{name: A, address: VB6000}", plc="cpu: CPU 222"))
    assert line == "items.yaml:1:89: PRJ018 VB6000: a CPU 222 has VB0 to VB2047"


def test_a_misspelt_key_is_answered_with_the_nearest_one() -> None:
    (line,) = errors(soft("{name: A, address: VW0, acces: R}"))
    assert line.endswith("did you mean 'access'?")


def test_a_key_of_another_link_type_is_said_to_be_one() -> None:
    (line,) = errors("links: [{name: L, type: soft, plcs: [{name: P, host: 192.0.2.1}]}]")
    assert "belongs to a link of type s7tcp or modbus-tcp" in line


def test_limits_the_wrong_way_round_are_swapped_with_a_warning() -> None:
    text = soft("{name: A, address: VW0, high: 200, low: 1000}")
    item = only_item(text)
    assert (item.low, item.high) == (200, 1000)
    assert ["PRJ021" in line for line in warnings(text)] == [True]


def test_links_that_are_not_served_yet_are_valid_and_said_to_be_silent() -> None:
    text = "links: [{name: L, type: ppi, port: COM1, plcs: [{name: P, address: 2, items: [{name: A, address: VW0}]}]}]"
    assert load_text(text).project.links[0].type is LinkType.PPI
    assert ["PRJ032" in line for line in warnings(text)] == [True]


@pytest.mark.parametrize("host", ["0.0.0.0", "192.0.2.1", "plant.example", "[::]"])
def test_an_endpoint_beyond_this_machine_is_refused(host: str) -> None:
    (line,) = errors(f"server: {{endpoint: 'opc.tcp://{host}:4840'}}\nlinks: []")
    assert "PRJ027" in line


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "[::1]", "127.1.2.3"])
def test_an_endpoint_on_this_machine_is_taken(host: str) -> None:
    project = load_text(f"server: {{endpoint: 'opc.tcp://{host}:4840'}}\nlinks: []").project
    assert project.server.endpoint == f"opc.tcp://{host}:4840"


@pytest.mark.parametrize(
    ("written", "place", "wished"),
    [
        ("", "127.0.0.1:8080", False),
        ("web: off", None, True),
        ("web: Off", None, True),
        ("web: on", "127.0.0.1:8080", True),
        ("web: 127.0.0.1:8081", "127.0.0.1:8081", True),
        ("web: 'localhost:0'", "localhost:0", True),
    ],
)
def test_the_web_server_is_off_by_one_key(written: str, place: str | None, wished: bool) -> None:
    server = load_text(f"server: {{{written}}}\nlinks: []").project.server
    assert (server.web, server.web_is_wished) == (place, wished)


@pytest.mark.parametrize(
    ("written", "code"),
    [
        ("0.0.0.0:80", "PRJ027"),
        ("plant.example:80", "PRJ027"),
        ("'8080'", "PRJ028"),
        ("'h:99999'", "PRJ028"),
        ("''", "PRJ028"),
    ],
)
def test_a_web_server_beyond_this_machine_or_nowhere_is_refused(written: str, code: str) -> None:
    (line,) = errors(f"server: {{web: {written}}}\nlinks: []")
    assert code in line
    assert "127.0.0.1:8080" in line


@pytest.mark.parametrize("clients", ["anyone may read", "Anyone may read and write"])
def test_a_web_server_is_opened_in_words(clients: str) -> None:
    server = load_text(f"server: {{web: '0.0.0.0:80', web_clients: {clients}}}\nlinks: []").project.server
    assert (server.web, server.web_clients.value) == ("0.0.0.0:80", clients.lower())


def test_words_that_do_not_exist_open_nothing() -> None:
    first, second = errors("server: {web: '0.0.0.0:80', web_clients: anyone}\nlinks: []")
    assert "PRJ027" in first
    assert "there is no 'anyone'" in second


# -- files ---------------------------------------------------------------------------------------------------------


def test_a_file_over_the_limit_is_refused_unless_the_limit_is_raised(tmp_path: Path) -> None:
    path = tmp_path / "items.yaml"
    path.write_text("links: []\n#" + "x" * 1000)
    with pytest.raises(ProblemError, match="--max-size"):
        load_project(path, max_size=1000)
    assert load_project(path, max_size=2000).project.links == ()


def test_paths_start_where_the_project_file_is(tmp_path: Path) -> None:
    (tmp_path / "p.awl").write_text("")
    (tmp_path / "items.yaml").write_text(soft("{name: A, address: VW0}", plc="program: p.awl"))
    loaded = load_project(tmp_path / "items.yaml")
    assert next(loaded.project.all_plcs()).program == tmp_path / "p.awl"
    assert loaded.files == (tmp_path / "items.yaml", tmp_path / "p.awl")
