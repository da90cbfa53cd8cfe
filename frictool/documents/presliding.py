"""`presliding` of `model.yaml`: the contact before breakaway, from slow hysteresis loops."""

from __future__ import annotations

from typing import Literal

import msgspec

from frictool.documents.quantity import (
    EffortEstimate,
    NonNegativeEffortEstimate,
    PositiveLengthEstimate,
    StiffnessEstimate,
    ViscousEstimate,
)

KEY = "presliding"  # key of the law's name in the record `log` of a simulated log


def presliding_words(owner: str, law: str) -> str:
    """Return the warning that verification does not include the presliding law of `owner`."""
    return (
        f"{owner} has presliding friction by {law}, which is simulated only: the controller's "
        "margins and certificate do not cover the stiffness of the contact"
    )


class Contact(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Parameters of one presliding law.

    A branch is the part of a hysteresis loop between two reversals. The law is fitted to some
    branches. The other branches (held out) test its prediction.

    - `stiffness`: Slope of the effort against the deflection, at rest.
    - `damping`: Damping, assumed to be 2 sqrt(inertia stiffness), because slow loops do not
      determine it.
    - `force_error`: Rms value of the residual on the fitted branches, divided by the breakaway.
    - `held_out`: Rms value of the residual on the held-out branches, divided by the breakaway.
    - `elastic_limit`: Deflection at which the elasto-plastic contact begins to slip.
    """

    # damping is sigma_1, elastic_limit z_ba of (2.46)
    stiffness: StiffnessEstimate
    damping: ViscousEstimate
    force_error: float
    held_out: float
    elastic_limit: PositiveLengthEstimate | None = None


class MaxwellSlip(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Initial loading curve of parallel Maxwell-slip elements: force over displacement from (0, 0).

    A branch is the part of a hysteresis loop between two reversals. The law is fitted to some
    branches. The other branches (held out) test its prediction.

    - `stiffness`: Slope of the curve at 0.
    - `displacement`: Displacements of the curve's points [rad | m].
    - `force`: Forces of the curve's points [N m | N].
    - `low`, `high`: Lower and upper ends of the intervals of the forces [N m | N].
    - `force_error`: Rms value of the residual on the fitted branches, divided by the breakaway.
    - `held_out`: Rms value of the residual on the held-out branches, divided by the breakaway.
    """

    stiffness: StiffnessEstimate
    displacement: tuple[float, ...]
    force: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    force_error: float
    held_out: float

    def __post_init__(self) -> None:
        if len({len(row) for row in (self.displacement, self.force, self.low, self.high)}) != 1:
            raise ValueError(
                "displacement, force, low, high: found different lengths; allowed: equal lengths"
            )


class Preisach(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Everett table of the Preisach law on a grid of positions.

    The entries of the table are efforts divided by `saturation`.

    - `limit`: Largest amplitude of the identification cycles.
    - `saturation`: Half of the difference between the efforts at +`limit` and -`limit`.
    - `table`: Rows of the table, with one row and one column for each grid position from -`limit`
      to +`limit`.
    - `half_width`: Half-width of the interval of each entry of `table`.
    """

    # the table of friction/preisach.py
    limit: PositiveLengthEstimate
    saturation: EffortEstimate
    table: tuple[tuple[float, ...], ...]
    half_width: tuple[tuple[float, ...], ...]

    def __post_init__(self) -> None:
        nodes = len(self.table)
        if (
            nodes < 3
            or any(len(row) != nodes for row in (*self.table, *self.half_width))
            or len(self.half_width) != nodes
        ):
            raise ValueError(
                f"table, half_width: found {nodes} rows; allowed: two square tables of one "
                "size, at least 3 x 3"
            )


# dynamic laws of friction/law_registry.py
ContactLaw = Literal["dahl", "lugre", "elasto_plastic", "leuven", "leuven_masing", "maxwell_slip"]


class Presliding(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Presliding laws of a model.

    - `law`: Law that simulations use. `identify` chooses the law with the best prediction of the
      held-out branches of the hysteresis loops; no law was fitted to these branches.
    - `limit`: Largest deflection z_max of the contacts, according to `law`.
    - `stiffness`: Slope of the effort against the deflection at 0, according to `law`.
    - `breakaway`: Breakaway with which the laws were fitted.
    - `lugre`, `elasto_plastic`, `maxwell_slip`, `preisach`: Parameters of the law with this name,
      if the loops determine them. If the parameters of `law` are absent, simulations use `limit`
      and `stiffness`.
    - `refused`: Reason for each law that the loops do not determine.
    """

    # 2.4.3
    law: ContactLaw
    limit: PositiveLengthEstimate
    stiffness: StiffnessEstimate
    breakaway: NonNegativeEffortEstimate
    lugre: Contact | None = None
    elasto_plastic: Contact | None = None
    maxwell_slip: MaxwellSlip | None = None
    preisach: Preisach | None = None
    refused: dict[str, str] = {}
