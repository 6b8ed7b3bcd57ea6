"""Shared by all tests. Keep it small: a fixture that one folder needs lives in that folder's conftest."""

from __future__ import annotations

import os
import signal

from hypothesis import HealthCheck, Phase, settings

# No deadline: machines that run the tests share their cores, and a slow example is not a wrong one.
settings.register_profile("pcaccess", deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True)
# A gate must answer the same for the same commit; new examples are found where CI is not set.
settings.register_profile("ci", settings.get_profile("pcaccess"), derandomize=True)
# tools/mutants.py wants to know whether a test fails, not the smallest example it fails with.
found_is_enough = [Phase.explicit, Phase.generate]
settings.register_profile("mutants", settings.get_profile("ci"), phases=found_is_enough, database=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE") or ("ci" if os.environ.get("CI") else "pcaccess"))

# A shell starts background jobs with Ctrl-C ignored, and every program below inherits that: the commands that tests
# interrupt would go on. A handler, unlike "ignored", does not outlive exec.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
