"""Thousands of robots before one is built: studies over tolerances, run in chunks, and what their trials say."""

from diffdrive_mj import _lazy

__getattr__, __dir__, __all__ = _lazy.attach(__name__, __file__)
