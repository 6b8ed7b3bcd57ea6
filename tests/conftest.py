"""Shared by all tests. Keep it small: a fixture that one folder needs lives in that folder's conftest."""

from __future__ import annotations

import os
import signal

from hypothesis import HealthCheck, settings

# No deadline: machines that run the tests share their cores, and a slow example is not a wrong one.
settings.register_profile("pcaccess", deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True)
# A gate must answer the same for the same commit; new examples are found where CI is not set.
settings.register_profile("ci", settings.get_profile("pcaccess"), derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "pcaccess")

# A shell starts background jobs with Ctrl-C ignored, and every program below inherits that: the commands that tests
# interrupt would go on. A handler, unlike "ignored", does not outlive exec.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
