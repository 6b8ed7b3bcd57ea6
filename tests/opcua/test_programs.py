"""A soft-PLC that runs a program, through a real client."""

from __future__ import annotations

from pathlib import Path

from asyncua import ua

from tests.gateways import Change, ScriptedClient, start_gateway

PROJECT = """
project: Test
links:
  - name: MicroWin
    type: soft
    plcs:
      - name: NewPLC
        address: 2
        cpu: CPU 224
        program: doubler.awl
        scan: 10ms
        items:
          - {name: Input, address: VW0, type: INT}
          - {name: Doubled, address: VW2, type: INT, access: R}
          - {name: Start, address: I0.0, type: BOOL}
          - {name: Motor, address: Q0.0, type: BOOL, access: R}
          - {name: Always, address: SM0.0, type: BOOL}
          - {name: Scans, address: VD10, type: DINT, access: R}
          - {name: Bits, address: "V20.6[4]", type: BOOL}
"""
DOUBLER = """ORGANIZATION_BLOCK MAIN:OB1
TITLE=Doubles VW0 into VW2, Q0.0 follows I0.0
BEGIN
Network 1
LD     SM0.0
MOVW   VW0, VW2
+I     VW0, VW2
INCD   VD10
Network 2
LD     I0.0
=      Q0.0
END_ORGANIZATION_BLOCK
"""
NEW_PLC = "ns=2;s=MicroWin.NewPLC"
SYSTEM = "ns=3;s=MicroWin.NewPLC"


def plant(folder: Path) -> Path:
    (folder / "doubler.awl").write_text(DOUBLER)
    (folder / "items.yaml").write_text(PROJECT)
    return folder / "items.yaml"


async def test_a_write_takes_effect_in_the_next_scan_and_is_published_once(tmp_path: Path) -> None:
    async with start_gateway(plant(tmp_path)) as running, running.client() as client:
        changes = await client.subscribe(f"{NEW_PLC}.Doubled")
        assert await changes.next() == Change(0)
        assert await client.put(f"{NEW_PLC}.Input", 21) == "Good"
        assert await client.value(f"{NEW_PLC}.Doubled") == 42
        assert await changes.next() == Change(42)
        assert changes.empty()


async def test_a_client_sets_an_input_and_the_program_answers_with_its_output(tmp_path: Path) -> None:
    async with start_gateway(plant(tmp_path)) as running, running.client() as client:
        for state in (True, False):
            assert await client.put(f"{NEW_PLC}.Start", state) == "Good"
            assert await client.value(f"{NEW_PLC}.Motor") is state


async def test_an_array_of_bits_reaches_the_running_plc(tmp_path: Path) -> None:
    async with start_gateway(plant(tmp_path)) as running, running.client() as client:
        assert await client.put(f"{NEW_PLC}.Bits", [True, False, True, True]) == "Good"
        assert await client.value(f"{NEW_PLC}.Bits") == [True, False, True, True]


async def test_special_memory_of_a_running_cpu_is_good(tmp_path: Path) -> None:
    async with start_gateway(plant(tmp_path)) as running, running.client() as client:
        assert await client.status(f"{NEW_PLC}.Always") == "Good"
        assert await client.status("ns=2;s=2,SM0.5,BOOL") == "Good"


async def test_stop_and_run_are_methods_of_the_plc(tmp_path: Path) -> None:
    async with start_gateway(plant(tmp_path)) as running, running.client() as client:
        assert await client.value(f"{SYSTEM}/Mode") == "RUN"
        mode = await client.subscribe(f"{SYSTEM}/Mode")
        assert (await mode.next()).value == "RUN"
        await client.call(NEW_PLC, f"{SYSTEM}/Stop")
        assert (await mode.next()).value == "STOP"
        stopped = await client.value(f"{NEW_PLC}.Scans")
        assert await client.put(f"{NEW_PLC}.Input", 5) == "Good"
        assert await client.value(f"{NEW_PLC}.Scans") == stopped
        await client.call(NEW_PLC, f"{SYSTEM}/Run")
        scans = await client.subscribe(f"{NEW_PLC}.Scans")
        first = (await scans.next()).value
        assert (await scans.next()).value > first


async def test_a_program_changed_by_a_reload_goes_in_between_two_scans_and_memory_stays(tmp_path: Path) -> None:
    path = plant(tmp_path)
    async with start_gateway(path) as running, running.client() as client:
        await client.put(f"{NEW_PLC}.Input", 7)
        (tmp_path / "doubler.awl").write_text(DOUBLER.replace("+I     VW0, VW2", "+I     100, VW2"))
        running.reload_file(path)
        changes = await client.subscribe(f"{NEW_PLC}.Doubled")
        await changes.until(Change(107))
        assert await client.put(f"{NEW_PLC}.Input", 8) == "Good"
        assert await client.value(f"{NEW_PLC}.Doubled") == 108


async def test_a_fatal_error_of_the_program_stops_its_cpu_and_nothing_else(tmp_path: Path) -> None:
    path = plant(tmp_path)
    endless = DOUBLER.replace("INCD   VD10", "INCD   VD10\nNetwork 3\nLBL 1\nLD SM0.0\nJMP 1")
    (tmp_path / "doubler.awl").write_text(endless)
    async with start_gateway(path) as running, running.client() as client:
        mode = await client.subscribe(f"{SYSTEM}/Mode")
        while (await mode.next()).value != "STOP":
            pass
        assert await client.put(f"{NEW_PLC}.Input", 3, ua.VariantType.Int16) == "Good"
        assert await client.value(f"{NEW_PLC}.Input") == 3


async def test_a_downloaded_program_runs_from_the_next_scan_on_and_memory_stays(tmp_path: Path) -> None:
    async with start_gateway(plant(tmp_path)) as running, running.client() as client:
        assert await client.put(f"{NEW_PLC}.Input", 9) == "Good"
        tripled = DOUBLER.replace("+I     VW0, VW2", "+I     VW0, VW2\n+I     VW0, VW2")
        accepted, problems = await download(client, tripled)
        assert (accepted, problems) == (True, [])
        assert await client.put(f"{NEW_PLC}.Start", True) == "Good"  # a scan has passed
        assert await client.value(f"{NEW_PLC}.Doubled") == 27


async def test_a_downloaded_program_with_errors_changes_nothing_and_says_where(tmp_path: Path) -> None:
    async with start_gateway(plant(tmp_path)) as running, running.client() as client:
        accepted, problems = await download(client, DOUBLER.replace("MOVW   VW0, VW2", "MOVW   VB0, VW2"))
        assert accepted is False
        assert len(problems) == 1
        assert problems[0].startswith("new.awl:6:8: STL")
        assert await client.put(f"{NEW_PLC}.Input", 4) == "Good"
        assert await client.value(f"{NEW_PLC}.Doubled") == 8


async def download(client: ScriptedClient, text: str) -> tuple[bool, list[str]]:
    name = ua.Variant("new.awl", ua.VariantType.String)
    accepted, problems = await client.call(
        NEW_PLC, f"{SYSTEM}/Download", name, ua.Variant(text.encode(), ua.VariantType.ByteString)
    )
    return accepted, problems or []
