"""Scan cycle, RUN and STOP, inputs and outputs, status bits, interrupts in time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from pcaccess.plc.cpu import Cpu, Mode
from pcaccess.plc.peripherals import AbsentPeripherals
from pcaccess.problems import Span
from pcaccess.s7200.address import AddressError, parse_address
from pcaccess.s7200.cpu import cpu_model
from pcaccess.s7200.types import DataType, ValueRangeError
from pcaccess.stl import layout
from pcaccess.stl.program import DataBlock, DataRow
from tests.plc.conftest import Bench, program

BOOL, INT, BYTE = DataType.BOOL, DataType.INT, DataType.BYTE
MakeBench = Callable[..., Bench]

WATCHDOG = "0003 scan watchdog: the program did not end in time"
FOLLOW = "LD I0.0\n= Q0.0\n"
COUNT = "LD SM0.0\nINCW VW0\n"
TIMED = """ORGANIZATION_BLOCK MAIN:OB1
TITLE=
BEGIN
NETWORK 1
LD SM0.1
MOVB 5, SMB34
ATCH INT_0, 10
ENI
NETWORK 2
LD SM0.0
MOVW VW0, VW2
NETWORK 3
LD SM0.0
MOVW VW0, VW4
END_ORGANIZATION_BLOCK
INTERRUPT_BLOCK INT_0:INT0
TITLE=
BEGIN
NETWORK 1
LD SM0.0
INCW VW0
END_INTERRUPT_BLOCK
"""


def test_a_scan_reads_inputs_first_and_writes_outputs_last(bench: MakeBench) -> None:
    plc = bench(FOLLOW)
    plc.cpu.set_inputs(b"\x01")
    assert (plc.bit("I0.0"), plc.cpu.outputs[0]) == (0, 0)
    plc.scan()
    assert (plc.bit("I0.0"), plc.cpu.outputs[0]) == (1, 1)


def test_a_write_to_an_input_is_the_terminal(bench: MakeBench) -> None:
    plc = bench(FOLLOW)
    plc.write("I0.0", BOOL, True)
    plc.scan()
    assert plc.cpu.inputs[0] == 1
    assert plc.bit("Q0.0") == 1
    plc.scan()
    assert plc.bit("Q0.0") == 1


class Witness(AbsentPeripherals):
    """Looks at the output terminals when the program switches the diagnosis LED on."""

    def __init__(self) -> None:
        self.cpu: Cpu | None = None
        self.seen = b""

    def diagnosis_led(self, on: bool) -> None:
        assert self.cpu is not None
        self.seen = self.cpu.outputs[:2]


@pytest.mark.parametrize("instruction", ["=I Q1.0", "SI Q1.0, 1", "BIW 1, QB1"])
def test_an_immediate_output_is_at_the_terminal_before_the_scan_ends(bench: MakeBench, instruction: str) -> None:
    witness = Witness()
    plc = bench(f"LD SM0.0\n= Q0.0\n{instruction}\nDLED 1\n", peripherals=witness)
    witness.cpu = plc.cpu
    plc.scan()
    assert (witness.seen, plc.cpu.outputs[:2]) == (b"\0\1", b"\1\1")


def test_a_write_to_memory_is_there_for_the_next_scan(bench: MakeBench) -> None:
    plc = bench(COUNT)
    plc.write("VW0", INT, 41)
    assert plc.word("VW0") == 0
    plc.scan()
    assert plc.word("VW0") == 42


def test_an_analog_input_is_read_as_it_was_written(bench: MakeBench) -> None:
    plc = bench("LD SM0.0\nMOVW AIW4, AQW0\n")
    plc.write("AIW4", INT, -32000)
    plc.scan()
    assert plc.word("AQW0") == -32000


def test_a_write_that_does_not_fit_is_refused_at_once(bench: MakeBench) -> None:
    plc = bench(COUNT)
    with pytest.raises(ValueRangeError):
        plc.write("VW0", INT, 40000)
    with pytest.raises(AddressError):
        plc.write("I0.0", INT, 1)


def test_in_stop_nothing_runs_and_inputs_are_still_shown(bench: MakeBench) -> None:
    plc = bench(COUNT)
    plc.cpu.stop()
    plc.write("I0.3", BOOL, True)
    plc.scan()
    assert (plc.word("VW0"), plc.bit("I0.3")) == (0, 1)


def test_stop_switches_outputs_off(bench: MakeBench) -> None:
    plc = bench("LD SM0.0\nS Q0.0, 1\n")
    plc.scan()
    plc.cpu.stop()
    assert (plc.cpu.outputs[0], plc.bit("Q0.0")) == (0, 0)


def test_stop_can_freeze_outputs(bench: MakeBench) -> None:
    plc = bench("LD SM0.0\nS Q0.0, 1\n", stop_outputs=None)
    plc.scan()
    plc.cpu.stop()
    assert plc.cpu.outputs[0] == 1


def test_run_without_a_program_stays_in_stop() -> None:
    cpu = Cpu(cpu_model())
    cpu.run(0.0)
    cpu.scan(0.0)
    assert cpu.mode is Mode.STOP


def test_the_first_scan_after_each_change_to_run_has_sm0_1(bench: MakeBench) -> None:
    plc = bench("LD SM0.1\nINCW VW0\n")
    plc.scan()
    plc.scan(after=10)
    assert plc.word("VW0") == 1
    plc.cpu.stop()
    plc.cpu.run(plc.now)
    plc.scan(after=10)
    assert plc.word("VW0") == 2


def test_sm0_3_is_on_in_the_first_scan_after_power_up_only(bench: MakeBench) -> None:
    plc = bench("LD SM0.3\nINCW VW0\n")
    plc.scan()
    plc.cpu.stop()
    plc.cpu.run(plc.now)
    plc.scan(after=10)
    assert plc.word("VW0") == 1


def test_memory_survives_stop_but_timers_edges_and_counter_bits_do_not(bench: MakeBench) -> None:
    plc = bench("LD SM0.0\nTON T37, 1\nTONR T5, 1\nLD SM0.0\nLD I0.7\nCTU C1, 1\n")
    for _ in range(3):
        plc.scan(after=100)
    plc.write("VW100", INT, 7)
    plc.scan(after=10)
    plc.cpu.stop()
    plc.cpu.run(plc.now)
    assert (plc.word("VW100"), plc.word("T37"), plc.word("T5"), plc.word("C1")) == (7, 0, 2, 1)
    assert (plc.bit("T37"), plc.bit("T5"), plc.bit("C1")) == (0, 0, 0)


@pytest.mark.parametrize(("bit", "half"), [("SM0.4", 30_000), ("SM0.5", 500)])
def test_the_clock_bits_are_on_and_off_for_half_their_period(bench: MakeBench, bit: str, half: int) -> None:
    plc = bench(COUNT)
    seen = []
    for now in (0, half - 1, half, 2 * half - 1, 2 * half):
        plc.cpu.scan(float(now))
        seen.append(plc.bit(bit))
    assert seen == [1, 1, 0, 0, 1]


def test_sm0_6_changes_from_scan_to_scan(bench: MakeBench) -> None:
    plc = bench(COUNT)
    seen = []
    for _ in range(4):
        plc.scan(after=1)
        seen.append(plc.bit("SM0.6"))
    assert seen == [1, 0, 1, 0]


def test_scan_times_are_last_shortest_and_longest(bench: MakeBench) -> None:
    plc = bench(COUNT)
    for distance in (0, 10, 30, 20):
        plc.scan(after=distance)
    assert [plc.word(a) for a in ("SMW22", "SMW24", "SMW26")] == [20, 10, 30]


def test_the_cpu_says_which_it_is() -> None:
    assert Cpu(cpu_model("CPU 226")).read(parse_address("SMB6"), BYTE) == 0b1001_0000


def test_the_logic_stack_can_be_seen_when_the_program_has_ended(bench: MakeBench) -> None:
    """Bit n is level n; LPP, ALD and OLD let a 0 in at the bottom."""
    full = bench("LDN I0.0\n" * 9)
    full.scan()
    popped = bench("LDN I0.0\n" * 9 + "ALD\n")
    popped.scan()
    words = [cpu.memory[layout.LOGIC_STACK : layout.LOGIC_STACK + 2].hex() for cpu in (full.cpu, popped.cpu)]
    assert words == ["01ff", "00ff"]


def test_the_watchdog_ends_an_endless_loop_and_says_so(bench: MakeBench) -> None:
    plc = bench("LBL 1\nLD SM0.0\nINCW VW0\nLD SM0.0\nJMP 1\n", loop_budget=100)
    plc.scan()
    assert plc.cpu.mode is Mode.STOP
    assert str(plc.cpu.fatal) == f"test.awl:5:1: {WATCHDOG} (MAIN (OB1), network 1)"


def test_an_endless_loop_in_an_interrupt_routine_ends_the_scan(bench: MakeBench) -> None:
    plc = bench(TIMED.replace("LD SM0.0\nINCW VW0", "LBL 1\nLD SM0.0\nJMP 1"), loop_budget=100)
    plc.scan()
    plc.write("VW0", INT, 5)
    plc.scan(after=1, load=9)  # due between the second and the third of three networks
    assert (plc.cpu.mode, plc.word("VW2"), plc.word("VW4")) == (Mode.STOP, 5, 0)
    assert str(plc.cpu.fatal) == f"test.awl:22:1: {WATCHDOG} (INT_0 (INT0), network 1)"
    assert len(plc.cpu.errors) == 1


def test_an_error_is_recorded_once_with_its_place_and_count(bench: MakeBench) -> None:
    plc = bench("NETWORK 1\nLD SM0.0\nMOVB *AC1, VB0\n")
    plc.scan()
    plc.scan(after=10)
    (record,) = plc.cpu.errors
    assert str(record) == "test.awl:3:1: 0006 indirect addressing error (MAIN (OB1), network 1)"
    assert (record.count, record.first, record.last) == (2, 0.0, 10.0)
    assert plc.bit("SM4.3") == 1


def test_errors_are_forgotten_with_the_next_run(bench: MakeBench) -> None:
    plc = bench("LD SM0.0\nMOVB *AC1, VB0\n")
    plc.scan()
    plc.cpu.stop()
    plc.cpu.run(10.0)
    assert (plc.cpu.errors, plc.bit("SM4.3")) == ([], 0)


def test_the_data_block_is_there_when_the_program_is() -> None:
    row = DataRow(10, b"\x00\x01\x00\x02", "VW10 1, 2", Span("test.db", 1, 1))
    cpu = Cpu(cpu_model("CPU 224"), replace(program(COUNT), data=DataBlock((row,))))
    assert [cpu.read(parse_address(a), INT) for a in ("VW10", "VW12")] == [1, 2]


def test_l_memory_of_a_subroutine_that_was_left_by_stop_is_given_back(bench: MakeBench) -> None:
    plc = bench(
        "ORGANIZATION_BLOCK MAIN:OB1\nTITLE=\nBEGIN\nNETWORK 1\nLD SM0.0\nMOVB 7, LB0\nCALL SBR_0\n"
        "END_ORGANIZATION_BLOCK\nSUBROUTINE_BLOCK SBR_0:SBR0\nTITLE=\nBEGIN\nNETWORK 1\nLD SM0.0\nMOVB 9, LB0\nSTOP\n"
        "END_SUBROUTINE_BLOCK\n"
    )
    plc.scan()
    assert (plc.cpu.mode, plc.byte("LB0"), plc.cpu.memory[layout.CALL_DEPTH]) == (Mode.STOP, 7, 0)


def test_timed_events_that_fall_due_in_a_scan_run_at_network_starts(bench: MakeBench) -> None:
    """A scan from 1 to 10 ms: its three networks start at 1, 4 and 7 ms, events are due at 5 and 10 ms."""
    plc = bench(TIMED)
    plc.scan()
    plc.scan(after=1, load=9)
    assert [plc.word(a) for a in ("VW2", "VW4", "VW0")] == [0, 1, 2]


def test_without_load_timed_events_run_at_the_border_of_scans(bench: MakeBench) -> None:
    plc = bench(TIMED)
    plc.scan()
    plc.scan(after=12)
    assert [plc.word(a) for a in ("VW2", "VW4", "VW0")] == [2, 2, 2]


def test_an_event_that_waits_runs_at_the_end_of_a_loops_round(bench: MakeBench) -> None:
    """All in one network: interrupts are switched on in the loop's first round."""
    loop = "LD SM0.0\nFOR VW2, 1, 3\nLD SM0.0\nENI\nNEXT\nDISI\n"
    plc = bench(INPUTS.format(event=0).replace("ENI\n", loop).replace("INCW VW0", "MOVW VW2, VW0"))
    plc.scan()
    plc.cpu.set_inputs(b"\x01")
    plc.scan(after=10)
    assert plc.word("VW0") == 2


def test_a_1_ms_timer_counts_within_a_scan(bench: MakeBench) -> None:
    plc = bench("NETWORK 1\nLD SM0.0\nTON T32, 5\nNETWORK 2\nLD T32\n= Q0.0\nNETWORK 3\nLD T32\n= Q0.1\n")
    plc.scan(load=9)
    assert (plc.bit("Q0.0"), plc.bit("Q0.1"), plc.word("T32")) == (0, 1, 9)


INPUTS = """ORGANIZATION_BLOCK MAIN:OB1
TITLE=
BEGIN
NETWORK 1
LD SM0.1
ATCH INT_0, {event}
ENI
END_ORGANIZATION_BLOCK
INTERRUPT_BLOCK INT_0:INT0
TITLE=
BEGIN
NETWORK 1
LD SM0.0
INCW VW0
END_INTERRUPT_BLOCK
"""


@pytest.mark.parametrize("event", range(8))
def test_an_edge_of_an_input_is_its_event(bench: MakeBench, event: int) -> None:
    """Events 0, 2, 4, 6: I0.0 to I0.3 rise; 1, 3, 5, 7: they fall (document 004, table 9.5)."""
    plc = bench(INPUTS.format(event=event))
    plc.scan()
    mask, falls = 1 << event // 2, event % 2
    counts = []
    for inputs in (mask, 0xFF, 0xFF & ~mask, 0):
        plc.cpu.set_inputs(bytes((inputs,)))
        plc.scan(after=10)
        counts.append(plc.word("VW0"))
    assert counts == ([0, 0, 1, 1] if falls else [1, 1, 1, 1])


def test_a_written_input_raises_its_event_too(bench: MakeBench) -> None:
    plc = bench(INPUTS.format(event=0))
    plc.scan()
    plc.write("I0.0", BOOL, True)
    plc.scan(after=10)
    assert plc.word("VW0") == 1


def test_an_interrupt_routine_is_not_interrupted(bench: MakeBench) -> None:
    """The second event waits until the first one's routine has ended, although that one polls."""
    second = "INTERRUPT_BLOCK INT_1:INT1\nTITLE=\nBEGIN\nNETWORK 1\nLD SM0.0\nMOVW 2, VW0\nEND_INTERRUPT_BLOCK\n"
    first = INPUTS.format(event=0).replace("ENI", "ATCH INT_1, 2\nENI").replace("INCW VW0", "MOVW 1, VW0")
    plc = bench(first + second)
    plc.scan()
    plc.cpu.set_inputs(b"\x03")
    plc.scan(after=10, load=5)
    assert plc.word("VW0") == 2


def test_an_event_queue_that_overflows_is_told_in_the_routine(bench: MakeBench) -> None:
    plc = bench(TIMED.replace("LD SM0.0\nINCW VW0", "LD SM4.2\n= M0.0\nLD SM0.0\nINCW VW0"))
    plc.scan()
    plc.scan(after=100)
    assert (plc.word("VW0"), plc.bit("M0.0"), plc.bit("SM4.2")) == (8, 1, 0)


def test_a_new_program_keeps_memory_and_mode(bench: MakeBench) -> None:
    plc = bench(COUNT)
    plc.scan()
    plc.cpu.load(program("LD SM0.0\n+I 10, VW0\n"))
    plc.scan(after=10)
    assert (plc.word("VW0"), plc.cpu.mode) == (11, Mode.RUN)


def test_edges_of_a_new_program_do_not_see_those_of_the_old_one(bench: MakeBench) -> None:
    plc = bench("LDN SM0.0\nEU\n= Q0.0\n")
    plc.scan()
    plc.cpu.load(program("LD SM0.0\nEU\nINCW VW0\n"))
    for _ in range(3):
        plc.scan(after=10)
    assert plc.word("VW0") == 0


def test_a_program_exchanged_with_memory_kept_does_not_write_its_data_block() -> None:
    row = DataRow(10, b"\x00\x05", "VW10 5", Span("test.db", 1, 1))
    cpu = Cpu(cpu_model("CPU 224"), program(COUNT))
    with_data = replace(program(COUNT), data=DataBlock((row,)))
    cpu.load(with_data, keep_memory=True)
    assert cpu.read(parse_address("VW10"), INT) == 0
    cpu.load(with_data)
    assert cpu.read(parse_address("VW10"), INT) == 5


def test_the_millisecond_counter_is_right_in_the_first_scan() -> None:
    cpu = Cpu(cpu_model("CPU 224"), program("LD SM0.0\nBITIM VD0\n"))
    cpu.run(5000.0)
    cpu.scan(5000.0)
    assert cpu.read(parse_address("VD0"), DataType.DINT) == 5000


def test_a_cpu_lives_in_the_memory_it_is_given() -> None:
    memory = bytearray(layout.BUFFER_SIZE)
    assert Cpu(cpu_model(), memory=memory).memory is memory


def test_a_clock_that_goes_back_stands_still(bench: MakeBench) -> None:
    plc = bench("LD SM0.0\nTON T37, 100\nBITIM VD0\n")
    for now in (0.0, 1000.0, 200.0, 1100.0):
        plc.cpu.scan(now)
    assert (plc.word("T37"), plc.word("VW2"), plc.word("SMW24")) == (11, 1100, 0)
