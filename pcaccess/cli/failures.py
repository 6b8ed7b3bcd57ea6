"""What a command says when it cannot do what was asked. Exit codes: 0 good, 1 failed, 2 used wrongly."""

from __future__ import annotations


class Failed(Exception):
    """The thing asked for failed; the message is for the user and says what to do."""
