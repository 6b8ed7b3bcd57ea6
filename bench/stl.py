"""STL at machine speed: the compiler beside the interpreter, gcc -O1 and pure-Python awlsim, in one run.

    python bench/stl.py [--json] [--sizes 1000,10000] [--kinds boolean,mixed,integer,real] [--awlsim DIR]

The same generated program runs in each, over the same changing inputs; figures are the best time of one execution of
OB1 by its number of instructions (awlsim's by its own: the same work needs other AWL). gcc compiles the same IR,
written as C; awlsim (PyPI) is installed into ``--awlsim`` or a temporary folder. What is missing is said and left out.
Memory is what a process of its own grows by when it loads the program, checking and lowering it included.

Targets at 10,000 instructions: at least 300 times awlsim and 50 times the interpreter, at most 4 times gcc -O1 before
background optimisation and at most 1.5 times after it.
"""

from __future__ import annotations

import argparse
import ctypes
import gc
import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from _stl_c import CProgram, has_gcc
from _stl_programs import KINDS, Text, first_memory, inputs, program

from pcaccess.plc.compiler import Compiled, why_unavailable
from pcaccess.plc.cpu import Cpu
from pcaccess.plc.interpreter import Interpreter
from pcaccess.s7200.address import Area
from pcaccess.s7200.cpu import cpu_model
from pcaccess.s7200.memory import AREA_START
from pcaccess.stl.checker import load_program
from pcaccess.stl.lower import lower

HERE = Path(__file__).parent
JUDGED = 10_000
"""Instructions of the programs that the targets are about."""
EXECUTIONS: dict[str, Callable[..., Any]] = {
    "compiled": lambda module, runtime: Compiled(module, runtime, optimise=False),
    "optimised": Compiled,
    "interpreter": Interpreter,
}


def cpu_with(text: Text, make: Callable[..., Any]) -> tuple[Cpu, float]:
    """A CPU in RUN with the program and the first memory, and the seconds that loading took."""
    checked = load_program(text.stl.encode(), file="bench.awl").unwrap()
    began = time.perf_counter()
    cpu = Cpu(cpu_model(), checked, make_executor=make)
    took = time.perf_counter() - began
    start = AREA_START[Area.V]
    for offset, data in first_memory():
        cpu.memory[start + offset : start + offset + len(data)] = data
    cpu.run(0.0)
    return cpu, took


def best_of(run: Callable[[], object], set_inputs: Callable[[bytes], object], seconds: float) -> float:
    """Seconds of the quickest execution: noise only adds."""
    changing = inputs()
    best, number, end = float("inf"), 0, time.perf_counter() + seconds
    while number < 4 or time.perf_counter() < end:
        set_inputs(changing[number % len(changing)])
        began = time.perf_counter()
        run()
        best = min(best, time.perf_counter() - began)
        number += 1
    return best


def measure_cpu(cpu: Cpu, seconds: float) -> float:
    module = cpu.module
    assert module is not None

    def put(data: bytes) -> None:
        cpu.memory[: len(data)] = data

    cpu.scan(0.0)
    executor = cpu._executor
    return best_of(lambda: executor.run(module.main), put, seconds)


def measure_gcc(text: Text, cpu: Cpu, folder: Path, name: str, seconds: float) -> tuple[float, float]:
    """Seconds of one execution, and of compiling. ``cpu`` gives a memory of its own."""
    program = load_program(text.stl.encode(), file="bench.awl").unwrap()
    compiled = CProgram(lower(program, cpu.model), folder, name)
    memory = cpu.memory
    address = ctypes.addressof((ctypes.c_char * len(memory)).from_buffer(memory))

    def put(data: bytes) -> None:
        memory[: len(data)] = data

    return best_of(lambda: compiled.main(address, compiled.environment), put, seconds), compiled.seconds


def measure_awlsim(texts: dict[str, Text], folder: Path, seconds: float) -> dict[str, float]:
    """Seconds of one cycle of each program; empty when awlsim cannot be had."""
    if not (folder / "awlsim").exists():
        command = [sys.executable, "-m", "pip", "install", "-q", "--target", str(folder), "awlsim"]
        if subprocess.run(command, capture_output=True).returncode:
            return {}
    task = {
        "programs": {name: text.awl for name, text in texts.items()},
        "inputs": [data.hex() for data in inputs()],
        "memory": [[offset, data.hex()] for offset, data in first_memory()],
        "seconds": seconds,
    }
    answer = subprocess.run(
        [sys.executable, str(HERE / "_stl_awlsim.py")],
        input=json.dumps(task),
        capture_output=True,
        text=True,
        env={"PYTHONPATH": str(folder)},
    )
    if answer.returncode:
        return {}
    times: dict[str, float] = json.loads(answer.stdout.splitlines()[-1])["seconds"]
    return times


def measure(kind: str, text: Text, folder: Path, seconds: float) -> dict[str, float]:
    """Nanoseconds by instruction of each execution, microseconds by instruction of compiling."""
    count = text.stl_count
    quick_cpu, quick_load = cpu_with(text, EXECUTIONS["compiled"])
    found = {"compiled": measure_cpu(quick_cpu, seconds) / count * 1e9, "load µs": quick_load / count * 1e6}
    better_cpu, _ = cpu_with(text, EXECUTIONS["optimised"])
    executor: Any = better_cpu._executor
    began = time.perf_counter()
    executor.start_optimising()
    executor.finish_optimising()
    found["optimising µs"] = (time.perf_counter() - began) / count * 1e6
    found["optimised"] = measure_cpu(better_cpu, seconds) / count * 1e9
    plain_cpu, _ = cpu_with(text, EXECUTIONS["interpreter"])
    found["interpreter"] = measure_cpu(plain_cpu, seconds) / count * 1e9
    if has_gcc():
        own_cpu, _ = cpu_with(text, EXECUTIONS["interpreter"])
        run, compiling = measure_gcc(text, own_cpu, folder, f"{kind}{count}", seconds)
        found["gcc -O1"], found["gcc µs"] = run / count * 1e9, compiling / count * 1e6
    return found


def memory_growth(execution: str, kind: str, size: int) -> int:
    """Bytes by which this process grows when it loads the program. Linux only: reads /proc."""
    cpu_with(program(kind, 100), EXECUTIONS[execution])  # what the first program of a process brings along
    before = _resident()
    cpu, _ = cpu_with(program(kind, size), EXECUTIONS[execution])
    executor: Any = cpu._executor
    if execution == "optimised":
        executor.start_optimising()
        executor.finish_optimising()
        cpu.scan(0.0)
    return _resident() - before


def _resident() -> int:
    gc.collect()
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize()


def measure_memory(kind: str, text: Text, size: int) -> dict[str, float]:
    """Bytes by instruction of each execution."""
    if not Path("/proc/self/statm").exists():
        return {}
    found = {}
    for execution in EXECUTIONS:
        command = [sys.executable, __file__, "--memory", execution, "--kinds", kind, "--sizes", str(size)]
        grown = int(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
        found[f"{execution} bytes"] = grown / text.stl_count
    return found


def judge(kind: str, found: dict[str, float]) -> list[dict[str, Any]]:
    def target(name: str, value: float, bound: float, *, least: bool) -> dict[str, Any]:
        holds = value >= bound if least else value <= bound
        sign = ">=" if least else "<="
        return {"name": f"{kind}: {name}", "value": round(value, 2), "target": f"{sign} {bound:g}", "holds": holds}

    targets = [target("times the interpreter", found["interpreter"] / found["compiled"], 50, least=True)]
    if "awlsim" in found:
        targets.append(target("times awlsim", found["awlsim"] / found["compiled"], 300, least=True))
    if "gcc -O1" in found:
        gcc = found["gcc -O1"]
        targets.append(target("to gcc -O1, not optimised", found["compiled"] / gcc, 4, least=False))
        targets.append(target("to gcc -O1, optimised", found["optimised"] / gcc, 1.5, least=False))
    return targets


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--sizes", default="1000,10000")
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--seconds", type=float, default=1.0, help="of each measurement")
    parser.add_argument("--awlsim", type=Path, help="folder that keeps awlsim for the next run")
    parser.add_argument("--memory", choices=EXECUTIONS, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.memory:
        print(memory_growth(options.memory, options.kinds, int(options.sizes)))
        return 0
    if reason := why_unavailable():
        print(f"there is no compiler here: {reason}", file=sys.stderr)
        return 1
    targets: list[dict[str, Any]] = []
    missing = set() if has_gcc() else {"gcc"}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for size in (int(text) for text in options.sizes.split(",")):
            texts = {kind: program(kind, size) for kind in options.kinds.split(",")}
            awlsim = measure_awlsim(texts, options.awlsim or folder / "peers", options.seconds)
            if not awlsim:
                missing.add("awlsim")
            for kind, text in texts.items():
                found = measure(kind, text, folder, options.seconds)
                if kind in awlsim:
                    found["awlsim"] = awlsim[kind] / text.awl_count * 1e9
                found |= measure_memory(kind, text, size)
                if size == JUDGED:
                    targets += judge(kind, found)
                if not options.json:
                    shown = ", ".join(f"{key} {value:.2f}" for key, value in found.items())
                    print(f"{kind}, {text.stl_count:,} instructions (each, ns unless said): {shown}")
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    if options.json:
        print(json.dumps({"targets": targets, "missing": sorted(missing), "peak_memory_mb": round(memory)}))
    else:
        print(f"most memory: {memory:.0f} MB" + (f"; missing: {', '.join(sorted(missing))}" if missing else ""))
        for entry in targets:
            print(f"{'holds' if entry['holds'] else 'MISSED'}  {entry['name']}: {entry['value']} ({entry['target']})")
    return 0 if all(entry["holds"] for entry in targets) else 1


if __name__ == "__main__":
    sys.exit(main())
