"""Shared by all tests. Keep it small: a fixture that one folder needs lives in that folder's conftest."""

from __future__ import annotations

from hypothesis import HealthCheck, settings

# No deadline: machines that run the tests share their cores, and a slow example is not a wrong one.
settings.register_profile("pcaccess", deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True)
settings.load_profile("pcaccess")
