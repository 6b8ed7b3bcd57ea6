"""``python -m pcaccess`` is the ``pcaccess`` command."""

from __future__ import annotations

from pcaccess.cli.main import main

if __name__ == "__main__":
    main()
