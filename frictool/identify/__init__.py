"""Identification of friction, breakaway and inertia of an axis from logs, with intervals.

Docstrings state the units of a rotary and of a linear axis separated by |, as in "rad | m".
Terms of the docstrings:

    bench               document bench.yaml: the hardware, with a-priori ranges of the parameters
    effort              torque of a rotary axis, force of a linear axis
    drive               current or voltage of the actuator
    count               smallest step of the encoder
    stroke              motion between two reversals
    slip                motion in one direction, in contrast to rest and presliding
    ramp                slow rise of the effort until the axis moves
    onset               instant at which a ramp starts to move the axis
    sliding parameters  inertia, viscous friction, Coulomb friction and offset
    load                effort that depends on the position, such as a spring, gravity or a ripple
    ripple              sine of the position, such as cogging torque
    effect              disturbance of the fit that is no load, such as a delay
    hypothesis          load or effect that may act
    row                 equation of motion at one sample, as an equation of a regression
    smoothing window    samples over which acceleration, velocity and effort are smoothed
    weak form           equation of motion times a smooth function, integrated over a window
    knee                speed at which the viscous friction changes
    force error         unexplained part of the effort in slip, relative to the effort
"""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.identify.from_logs import IdentifiedModel as IdentifiedModel
    from frictool.identify.from_logs import identify as identify
    from frictool.identify.identification import NothingIdentified as NothingIdentified
    from frictool.identify.methods import METHODS as METHODS
    from frictool.identify.methods import IdentificationRequest as IdentificationRequest
    from frictool.identify.methods import IdentificationSettings as IdentificationSettings
else:
    __getattr__, __dir__, __all__ = lazy_exports(
        __name__,
        {
            "from_logs": ["IdentifiedModel", "identify"],
            "identification": ["NothingIdentified"],
            "methods": ["IdentificationRequest", "IdentificationSettings", "METHODS"],
        },
    )
