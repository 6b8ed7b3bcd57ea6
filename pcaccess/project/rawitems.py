"""The shape of items and folders in ``items.yaml``, for each kind of link; the first half of ``pcaccess.project.raw``.

The descriptions are what editors show (``pcaccess schema``) and what docs/items-yaml.md says.
"""

from __future__ import annotations

from typing import Annotated, Any, Final

from pydantic import BaseModel, ConfigDict, Field, model_validator

from pcaccess.s7200.types import DATA_TYPE_NAMES


def words(*words: str) -> dict[str, Any]:
    """Offer these words in editors; the loader takes them in any case."""
    return {"anyOf": [{"enum": list(words)}, {"type": "string"}], "type": None}


TYPE_WORDS: Final = words(*DATA_TYPE_NAMES)
_WRITE_LIMITS: Final = words("none", "refuse", "clamp")
Name = Annotated[
    str,
    Field(description="Name; part of the item ID, so without . , : / and control characters.", examples=["Motor"]),
]
Description = Annotated[str, Field(description="What it is, in the plant's words; clients see it.")]
Limit = Annotated[
    float | None,
    Field(
        allow_inf_nan=False,
        description="End of the engineering range (EURange); high and low come together. Restricts nothing by itself.",
    ),
]
Unit = Annotated[str, Field(description="Engineering unit.", examples=["°C", "bar"])]
AccessWord = Annotated[
    str | None,
    Field(
        description="R, W or RW. Left out it is RW, and R for what nobody can write: HC, SM0 to SM29, simulated waves.",
        json_schema_extra=words("R", "W", "RW"),
    ),
]
WriteLimitsWord = Annotated[
    str | None,
    Field(
        description="What a write outside low..high does: none (it is let through), refuse (BadOutOfRange), clamp "
        "(the nearer end is written). On a PLC: for all its items that have limits.",
        json_schema_extra=_WRITE_LIMITS,
    ),
]


class Raw(BaseModel):
    """Unknown keys are errors, never ignored."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _nothing_is_left_out(cls, data: object) -> object:
        """``items:`` with nothing behind it is as if the key were not there."""
        if isinstance(data, dict) and None in data.values():
            return {k: v for k, v in data.items() if v is not None or k not in cls.model_fields}
        return data


class RawScaling(Raw):
    """A straight line from the number in the PLC to the engineering value."""

    raw: Annotated[
        list[Annotated[float, Field(allow_inf_nan=False)]],
        Field(min_length=2, max_length=2, description="Number in the PLC at both ends.", examples=[[0, 32000]]),
    ]
    scaled: Annotated[
        list[Annotated[float, Field(allow_inf_nan=False)]],
        Field(min_length=2, max_length=2, description="Engineering value at both ends.", examples=[[0, 10]]),
    ]
    clamp: Annotated[bool, Field(description="Hold values beyond the ends at the nearer end.")] = False


class AnyItem(Raw):
    name: Name
    type: Annotated[
        str | None,
        Field(
            description="Data type clients see. Left out: BOOL for a bit, BYTE for a byte, INT for a word, T and C, "
            "DINT for a double word, REAL for a scaled item.",
            json_schema_extra=TYPE_WORDS,
        ),
    ] = None
    access: AccessWord = None
    high: Limit = None
    low: Limit = None
    unit: Unit = ""
    description: Description = ""
    write_limits: WriteLimitsWord = None


class S7Item(AnyItem):
    """A value in the memory of an S7-200."""

    address: Annotated[
        str,
        Field(
            description="S7-200 address: I0.0, VB100, VW2, MD4, T37, C5, AIW0; an array as VW0[10].",
            examples=["VW0", "Q0.0"],
        ),
    ]
    length: Annotated[int | None, Field(ge=1, le=254, description="Characters a STRING has room for (254).")] = None
    scaling: Annotated[RawScaling | None, Field(description="Makes the item a REAL in engineering units.")] = None
    raw_type: Annotated[
        str | None,
        Field(
            description="Type in the PLC of a scaled item. Left out: signed, as wide as the address.",
            json_schema_extra=TYPE_WORDS,
        ),
    ] = None


class SimItem(AnyItem):
    """A value that the gateway makes up."""

    address: Annotated[
        str,
        Field(
            description="RAMP(period, low, high), SINE(...), RANDOM(...), TOGGLE(period), COUNTER(period), "
            "CONST(value) or QUALITY(code, value).",
            examples=["SINE(10s, 0, 100)"],
        ),
    ]


class OpcUaItem(AnyItem):
    """A variable of another OPC UA server."""

    address: Annotated[str, Field(description="NodeId on that server.", examples=["ns=2;s=A.B.T1"])]
    type: Annotated[
        str | None, Field(description="Data type clients see; needed here.", json_schema_extra=TYPE_WORDS)
    ] = None


class AnyFolder(Raw):
    name: Name
    description: Description = ""


FOLDERS: Final[Any] = Field(default=[], description="Folders in it; they may nest.")
ITEMS: Final[Any] = Field(default=[], description="The items in it.")


class S7Folder(AnyFolder):
    """A named level between PLC and item."""

    folders: list[S7Folder] = FOLDERS
    items: list[S7Item] = ITEMS


class SimFolder(AnyFolder):
    """A named level between PLC and item."""

    folders: list[SimFolder] = FOLDERS
    items: list[SimItem] = ITEMS


class OpcUaFolder(AnyFolder):
    """A named level between PLC and item."""

    folders: list[OpcUaFolder] = FOLDERS
    items: list[OpcUaItem] = ITEMS
