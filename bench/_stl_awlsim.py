"""Runs in a Python that has awlsim: times programs in its pure-Python core.

    python bench/_stl_awlsim.py < {"programs": {name: awl}, "inputs": [hex], "memory": [[offset, hex]], "seconds": 1.0}

Prints ``{"version": ..., "seconds": {name: seconds of one cycle}, "load": {name: seconds}}``.
"""

from __future__ import annotations

import json
import sys
import time
from typing import Any


def load(text: str, memory: list[list[object]]) -> Any:
    # Its modules know each other only when they are loaded in this order.
    import awlsim_loader.common  # noqa: F401
    from awlsim_loader.core import AwlSim  # isort: skip
    from awlsim_loader.awlcompiler import AwlParser  # isort: skip

    parser = AwlParser()
    parser.parseText(text)
    simulator = AwlSim()
    simulator.reset()
    cpu = simulator.getCPU()
    cpu.getConf().setCycleTimeLimitUs(10**9)
    simulator.load(parser.getParseTree())
    simulator.build()
    simulator.startup()
    flags = cpu.flags.getRawDataBytes()
    for offset, data in memory:
        raw = bytes.fromhex(str(data))
        start = 100 + int(str(offset))
        flags[start : start + len(raw)] = raw
    return simulator


def seconds_for_a_cycle(simulator: Any, inputs: list[bytes], seconds: float) -> float:
    """The best of several rounds, as for all others."""
    cpu = simulator.getCPU()
    image = cpu.inputs.getRawDataBytes()
    best, number, end = float("inf"), 0, time.perf_counter() + seconds
    while number < 4 or time.perf_counter() < end:
        image[: len(inputs[0])] = inputs[number % len(inputs)]
        start = time.perf_counter()
        simulator.runCycle()
        best = min(best, time.perf_counter() - start)
        number += 1
    return best


def main() -> None:
    from awlsim.common.version import VERSION_STRING

    task = json.load(sys.stdin)
    inputs = [bytes.fromhex(text) for text in task["inputs"]]
    times, loads = {}, {}
    for name, text in task["programs"].items():
        start = time.perf_counter()
        simulator = load(text, task["memory"])
        loads[name] = time.perf_counter() - start
        times[name] = seconds_for_a_cycle(simulator, inputs, task["seconds"])
    print(json.dumps({"version": VERSION_STRING, "seconds": times, "load": loads}))


if __name__ == "__main__":
    main()
