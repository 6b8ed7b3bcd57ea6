"""CPU models: which addresses each generation has."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pcaccess.s7200.address import AddressError, Area, parse_address
from pcaccess.s7200.cpu import CPU_MODELS, CPU_NAMES, CpuError, CpuModel, cpu_model
from pcaccess.s7200.memory import AREA_BYTES


@pytest.mark.parametrize(
    ("name", "generation", "v", "sm", "analog"),
    [
        ("CPU 221", 2, 2048, 180, 0),
        ("CPU 222", 2, 2048, 300, 32),
        ("CPU 224", 2, 8192, 550, 64),
        ("CPU 224XP", 2, 10240, 550, 64),
        ("CPU 226", 2, 10240, 550, 64),
        ("CPU 226XM", 2, 10240, 550, 64),
        ("CPU 221", 1, 2048, 180, 32),
        ("CPU 224", 1, 5120, 550, 64),
        ("CPU 226", 1, 5120, 550, 64),
        ("CPU 226XM", 1, 10240, 550, 64),
    ],
)
def test_each_model_has_the_memory_of_its_data_sheet(name: str, generation: int, v: int, sm: int, analog: int) -> None:
    model = cpu_model(name, generation)
    assert (model.sizes[Area.V], model.sizes[Area.SM], model.sizes[Area.AI], model.sizes[Area.AQ]) == (
        v,
        sm,
        analog,
        analog,
    )


@pytest.mark.parametrize("name", ["CPU 224", "cpu224", "224", " Cpu  224 "])
def test_a_model_is_found_however_it_is_written(name: str) -> None:
    assert cpu_model(name).name == "CPU 224"


@pytest.mark.parametrize(
    ("name", "generation", "said"),
    [
        ("CPU 223", 2, "there is no 'CPU 223'; the models are CPU 221, CPU 222,"),
        ("CPU 224PX", 2, "did you mean CPU 224XP?"),
        ("S7-300", 2, "there is no 'S7-300'"),
        ("CPU 224", 3, "generation 3 does not exist"),
        ("CPU 224XP", 1, "CPU 224XP exists only in generation 2"),
    ],
)
def test_no_other_model_is_found(name: str, generation: int, said: str) -> None:
    with pytest.raises(CpuError) as caught:
        cpu_model(name, generation)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("name", "last", "beyond", "said"),
    [
        ("CPU 222", "VB2047", "VB2048", "VB2048: a CPU 222 has VB0 to VB2047"),
        ("CPU 222", "VW2046", "VW2047", "VB0 to VB2047"),
        ("CPU 222", "VD2044", "VD2045", "VB0 to VB2047"),
        ("CPU 222", "V2047.7", "V2048.0", "VB0 to VB2047"),
        ("CPU 222", "V2047.0[8]", "V2047.0[9]", "VB0 to VB2047"),
        ("CPU 222", "VW0[1024]", "VW0[1025]", "VB0 to VB2047"),
        ("CPU 222", "SMB299", "SMB300", "SMB0 to SMB299"),
        ("CPU 222", "AIW30", "AIW32", "AIW0 to AIW30"),
        ("CPU 221", "I15.7", "I16.0", "IB0 to IB15"),
        ("CPU 226", "M31.7", "MW31", "MB0 to MB31"),
        ("CPU 226", "LB63", "LB64", "LB0 to LB63"),
        ("CPU 226", "T255", "T256", "T0 to T255"),
        ("CPU 226", "C250[6]", "C250[7]", "C0 to C255"),
        ("CPU 226", "HC5", "HC6", "HC0 to HC5"),
        ("CPU 226", "AC3", "AC4", "AC0 to AC3"),
    ],
)
def test_the_last_address_exists_and_the_next_says_why_it_does_not(
    name: str, last: str, beyond: str, said: str
) -> None:
    model = cpu_model(name)
    model.check(parse_address(last))
    with pytest.raises(AddressError) as caught:
        model.check(parse_address(beyond))
    assert str(caught.value) == f"{beyond}: a {name} has {said.split(' has ')[-1]}"


def test_a_cpu_221_has_no_analog_values() -> None:
    with pytest.raises(AddressError, match="AIW0: a CPU 221 has no analog inputs"):
        cpu_model("CPU 221").check(parse_address("AIW0"))


def test_a_string_needs_all_its_room() -> None:
    model = cpu_model("CPU 222")
    model.check(parse_address("VB1793"), size=255)
    with pytest.raises(AddressError):
        model.check(parse_address("VB1794"), size=255)


@given(st.sampled_from(list(CPU_MODELS.values())), st.sampled_from(list(Area)))
def test_the_range_that_a_message_names_is_the_one_that_exists(model: CpuModel, area: Area) -> None:
    if model.sizes[area] == 0:
        return
    first, last = model.range_text(area).split(" to ")
    model.check(parse_address(first))
    model.check(parse_address(last))


def test_no_model_has_more_of_an_area_than_the_buffer() -> None:
    element = {Area.T: 2, Area.C: 2, Area.HC: 4, Area.AC: 4}
    for model in CPU_MODELS.values():
        for area, size in model.sizes.items():
            assert size * element.get(area, 1) <= AREA_BYTES[area]


def test_every_name_has_a_model_of_the_newest_generation() -> None:
    assert [cpu_model(name).generation for name in CPU_NAMES] == [2] * len(CPU_NAMES)
