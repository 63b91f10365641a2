"""For people: experiments' answers, tables and pictures."""

from diffdrive_mj import _lazy

__getattr__, __dir__, __all__ = _lazy.attach(__name__, __file__)
