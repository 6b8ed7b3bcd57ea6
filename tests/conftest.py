"""Shared by all tests. Keep it small: a fixture that one folder needs lives in that folder's conftest."""

from __future__ import annotations

import os

from hypothesis import HealthCheck, settings

# No deadline: machines that run the tests share their cores, and a slow example is not a wrong one.
settings.register_profile("pcaccess", deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True)
# A gate must answer the same for the same commit; new examples are found where CI is not set.
settings.register_profile("ci", settings.get_profile("pcaccess"), derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "pcaccess")
