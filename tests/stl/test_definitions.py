"""What the definition table says about every instruction."""

from __future__ import annotations

import pytest

from pcaccess.s7200.address import Area
from pcaccess.s7200.types import DataType
from pcaccess.stl.define import Definition, Direction, Power
from pcaccess.stl.definitions import DEFINITIONS

ALL = pytest.mark.parametrize("definition", DEFINITIONS.values(), ids=lambda d: d.mnemonic)


def test_the_whole_instruction_set_is_known() -> None:
    assert len(DEFINITIONS) == 247  # 246 of a CPU 22x, and MEND of old programs


@ALL
def test_every_definition_names_its_source_and_says_what_it_does(definition: Definition) -> None:
    assert definition.source
    assert definition.summary.endswith(".")


@ALL
def test_every_value_operand_can_lie_somewhere(definition: Definition) -> None:
    assert all(o.areas for o in definition.operands if o.is_value)


@ALL
def test_only_boxes_and_control_set_eno(definition: Definition) -> None:
    assert not definition.eno_off or definition.power in (Power.BOX, Power.CONTROL)


def test_a_family_row_gives_its_type_to_the_operands() -> None:
    one, two = DEFINITIONS["+D"].operands
    assert (one.type, one.direction, one.constant) == (DataType.DINT, Direction.IN, True)
    assert (two.type, two.direction, two.constant) == (DataType.DINT, Direction.INOUT, False)


def test_an_output_word_is_written_but_not_changed_in_place() -> None:
    assert Area.AQ in DEFINITIONS["MOVW"].operands[1].areas
    assert Area.AQ not in DEFINITIONS["INCW"].operands[0].areas


def test_the_first_of_a_row_of_values_is_no_accumulator() -> None:
    assert Area.AC not in DEFINITIONS["BMD"].operands[0].areas
