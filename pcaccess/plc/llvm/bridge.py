"""The Python side of compiled code: what it calls, and what becomes of an exception there.

No exception crosses machine code: it is kept, the code unwinds because word 0 of its environment says so, and
:meth:`Bridge.raise_failure` raises it again where the code was called.

Units:    a call from machine code costs about a microsecond; it takes the GIL, which a scan does not hold.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any, Final

from pcaccess.plc.llvm import abi
from pcaccess.stl.runtime import Runtime

_TYPES: Final[dict[str, Any]] = {"i": ctypes.c_longlong, "u": ctypes.c_ulonglong, "d": ctypes.c_double, "v": None}
_RESULTS: Final[dict[str, Callable[[Any], Any]]] = {"i": int, "u": int, "d": float, "v": lambda _: None}
_FAILURES: Final = {"i": 0, "u": 0, "d": 0.0, "v": None}
_UNWIND: Final = 1


class Bridge:
    """The environment of one program for one CPU (``pcaccess.plc.llvm.abi``)."""

    def __init__(self, runtime: Runtime, sites: abi.Sites) -> None:
        self._runtime = runtime
        self._failure: BaseException | None = None
        self._calls = [(call.function, call.static) for call in sites.calls]
        self._functions = [
            ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_int)(self._poll),
            ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_int)(self._out_of_budget),
            ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_int, ctypes.c_int)(self._fault),
            *(self._cold(signature) for signature in sites.signatures),
        ]
        self._words = (ctypes.c_int64 * (1 + len(self._functions)))()
        for n, function in enumerate(self._functions, 1):
            self._words[n] = ctypes.cast(function, ctypes.c_void_p).value or 0
        self.address = ctypes.addressof(self._words)

    def raise_failure(self) -> None:
        """Raise what a Python function raised since the last call, if one did."""
        if self._failure is not None:
            failure, self._failure = self._failure, None
            self._words[abi.FAILED] = 0
            raise failure

    def _failed(self, error: BaseException) -> int:
        if self._failure is None:
            self._failure = error
        self._words[abi.FAILED] = 1
        return _UNWIND

    def _poll(self, network: int) -> int:
        try:
            return int(self._runtime.poll(network))
        except BaseException as error:
            return self._failed(error)

    def _out_of_budget(self, place: int) -> int:
        try:
            return int(self._runtime.out_of_budget(place))
        except BaseException as error:
            return self._failed(error)

    def _fault(self, code: int, place: int) -> int:
        try:
            self._runtime.fault(code, place)
        except BaseException as error:
            return self._failed(error)
        return 0

    def _cold(self, signature: str) -> Any:
        """The function that all cold instructions of one signature call."""
        runtime, calls = self._runtime, self._calls
        result, failure = _RESULTS[signature[0]], _FAILURES[signature[0]]

        def call(site: int, *arguments: float) -> Any:
            try:
                function, static = calls[site]
                return result(function(runtime, *static, *arguments))
            except BaseException as error:
                self._failed(error)
                return failure

        return ctypes.CFUNCTYPE(_TYPES[signature[0]], ctypes.c_int, *(_TYPES[letter] for letter in signature[1:]))(call)
