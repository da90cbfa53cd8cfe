"""Models and controllers as linear systems, for python-control and scipy, and theirs for frictool."""

from typing import TYPE_CHECKING

from frictool.exports import lazily

if TYPE_CHECKING:
    from frictool.systems.others import as_lti as as_lti
    from frictool.systems.python_control import to_control as to_control
    from frictool.systems.scipy_signal import to_scipy as to_scipy
    from frictool.systems.views import controller_system as controller_system
    from frictool.systems.views import loop_system as loop_system
    from frictool.systems.views import plant_system as plant_system
else:
    __getattr__, __dir__ = lazily(
        __name__,
        {
            "as_lti": "frictool.systems.others",
            "controller_system": "frictool.systems.views",
            "loop_system": "frictool.systems.views",
            "plant_system": "frictool.systems.views",
            "to_control": "frictool.systems.python_control",
            "to_scipy": "frictool.systems.scipy_signal",
        },
    )

__all__ = ["as_lti", "controller_system", "loop_system", "plant_system", "to_control", "to_scipy"]
