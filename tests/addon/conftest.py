"""Fixtures of the add-on's tests; what they are made of is in hosts.py."""

from hosts import host  # noqa: F401
