"""The ``pcaccess`` command, also as ``python -m pcaccess``.

Loading its modules takes a moment. Ctrl-C in that moment ends the process as it ends any other, without a traceback;
so it does at the very end, when there is nothing left to stop.
"""

from __future__ import annotations

import signal


def main() -> None:
    """Entry point of the console script."""
    interruptible = signal.getsignal(signal.SIGINT) is signal.default_int_handler  # not in a shell's background
    if interruptible:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from pcaccess.cli.main import main as command

    if interruptible:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        command()
    finally:
        if interruptible:
            signal.signal(signal.SIGINT, signal.SIG_DFL)


if __name__ == "__main__":
    main()
