"""The name under which the synthesis was known before it had a continuous form; see `hinf`."""

from frictool.lmi.hinf import Lyapunov, controller, minimise

__all__ = ["Lyapunov", "controller", "minimise"]
