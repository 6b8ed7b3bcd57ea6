"""Names that exist without a symbol table: those of special memory that Micro/WIN adds to a project.

Source:   Micro/WIN's table "S7-200 Symbols"; document 004 uses ``HSC0_Ctrl``, ``PLS0_Cycle``, ``PTO0_PC``;
          addresses from the SM memory map, document 000, appendix C.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final, NamedTuple

from pcaccess.s7200.address import Address, parse_address


class Predefined(NamedTuple):
    name: str
    address: Address


_NAMES: Final = {
    "Always_On": "SM0.0",
    "First_Scan_On": "SM0.1",
    "Retentive_Lost": "SM0.2",
    "RUN_Power_Up": "SM0.3",
    "Clock_60s": "SM0.4",
    "Clock_1s": "SM0.5",
    "Clock_Scan": "SM0.6",
    "Mode_Switch": "SM0.7",
    "Result_0": "SM1.0",
    "Overflow_Illegal": "SM1.1",
    "Neg_Result": "SM1.2",
    "Divide_By_0": "SM1.3",
    "Table_Overflow": "SM1.4",
    "Table_Empty": "SM1.5",
    "Not_BCD": "SM1.6",
    "Not_Hex": "SM1.7",
    "Receive_Char": "SMB2",
    "Parity_Err": "SM3.0",
    "Comm_Int_Ovr": "SM4.0",
    "Input_Int_Ovr": "SM4.1",
    "Timed_Int_Ovr": "SM4.2",
    "RUN_Err": "SM4.3",
    "Int_Enabled": "SM4.4",
    "Xmit0_Idle": "SM4.5",
    "Xmit1_Idle": "SM4.6",
    "Force_On": "SM4.7",
    "IO_Err": "SM5.0",
    "Too_Many_D_IO": "SM5.1",
    "Too_Many_A_IO": "SM5.2",
    "Too_Many_I_IO": "SM5.3",
    "Time_0_Intrvl": "SMB34",
    "Time_1_Intrvl": "SMB35",
    "P0_Config": "SMB30",
    "P1_Config": "SMB130",
    "P0_Stat_Rcv": "SMB86",
    "P0_Ctrl_Rcv": "SMB87",
    "P0_Start_Char": "SMB88",
    "P0_End_Char": "SMB89",
    "P0_Idle_Time": "SMW90",
    "P0_Timeout": "SMW92",
    "P0_Max_Char": "SMB94",
    "P1_Stat_Rcv": "SMB186",
    "P1_Ctrl_Rcv": "SMB187",
    "P1_Start_Char": "SMB188",
    "P1_End_Char": "SMB189",
    "P1_Idle_Time": "SMW190",
    "P1_Timeout": "SMW192",
    "P1_Max_Char": "SMB194",
    **{
        f"HSC{number}_{name}": f"SM{width}{start + offset}"
        for number, start in ((0, 36), (1, 46), (2, 56), (3, 136), (4, 146), (5, 156))
        for name, width, offset in (("Status", "B", 0), ("Ctrl", "B", 1), ("CV", "D", 2), ("PV", "D", 6))
    },
    **{
        f"{name}{number}_{rest}": f"SM{width}{start + offset}"
        for number, start in ((0, 66), (1, 76))
        for name, rest, width, offset in (
            ("PTO", "Status", "B", 0),
            ("PLS", "Ctrl", "B", 1),
            ("PLS", "Cycle", "W", 2),
            ("PWM", "PW", "W", 4),
            ("PTO", "PC", "D", 6),
        )
    },
}
PREDEFINED: Final[Mapping[str, Predefined]] = MappingProxyType(
    {name.casefold(): Predefined(name, parse_address(address)) for name, address in _NAMES.items()}
)
"""By casefolded name."""
