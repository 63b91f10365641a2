"""What can be known of a motion beyond its odometry: derivatives, courses from fixes, closed forms."""

from diffdrive_mj import _lazy

__getattr__, __dir__, __all__ = _lazy.attach(__name__, __file__)
