"""Closed-loop gains of several plants as functions of a controller's frequency response.

    T = P11 + P12 K/(1 - P22 K) P21
    sigma = u^H T v        dsigma = Re(u^H P12 P21 v dK/(1 - P22 K)²)

P11 to P22 are the blocks of the generalised plant, K is the controller, and T the closed loop.
sigma is the largest singular value, u and v are its singular vectors. K has one input and one
output, and is thus a complex number at each frequency. Thousands of responses can therefore be
evaluated together. The sensitivity S = 1/(1 - P22 K) is the special case P11 = P21 = 1 and P12 =
P22.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from frictool.plant.generalised_plant import GeneralisedPlant
from frictool.plant.lti import Lti
from frictool.typing import ComplexVector, Vector
from frictool.verify.hinf_norm import norm


@dataclass(frozen=True)
class OpenLoopResponses:
    """Frequency responses P11 to P22 of one or several plants.

    The shapes are p11 (k, z, w), p12 (k, z), p21 (k, w) and p22 (k,) for k frequencies of all
    plants together, z weighted outputs and w disturbances.
    """

    p11: ComplexVector
    p12: ComplexVector
    p21: ComplexVector
    p22: ComplexVector

    @staticmethod
    def of(plant: GeneralisedPlant, frequencies: Vector) -> OpenLoopResponses:
        """Return the responses of one plant at the angular frequencies (k,) [rad/s]."""
        z, w = plant.d11.shape
        d = np.block([[plant.d11, plant.d12], [plant.d21, np.zeros((1, 1))]])
        whole = Lti(
            plant.a,
            np.hstack([plant.b1, plant.b2]),
            np.vstack([plant.c1, plant.c2]),
            d,
            plant.period,
        )
        p = whole.response(frequencies)
        return OpenLoopResponses(p[:, :z, :w], p[:, :z, w], p[:, z, :w], p[:, z, w])

    @staticmethod
    def joined(parts: Sequence[OpenLoopResponses]) -> OpenLoopResponses:
        """Return the responses of several plants, one plant after another."""
        return OpenLoopResponses(
            *(
                np.concatenate([getattr(part, name) for part in parts])
                for name in ("p11", "p12", "p21", "p22")
            )
        )

    def sensitivity(self) -> OpenLoopResponses:
        """Return the open-loop responses whose closed loop is the sensitivity."""
        one = np.ones_like(self.p22)
        return OpenLoopResponses(one[:, None, None], self.p22[:, None], one[:, None], self.p22)

    def gains(self, k: ComplexVector) -> Vector:
        """Return the largest singular values (k,) of the closed loop with the controller `k`."""
        _, gram = self._gram(k)
        return np.asarray(np.sqrt(np.maximum(np.linalg.eigvalsh(gram)[:, -1], 0.0)))

    def bounds(self, k: ComplexVector) -> Vector:
        """Return the Frobenius norms (k,) of the closed loop, which are upper bounds of the gains.

        The bounds need much less time than the gains, and exceed the gains by a factor of at most
        sqrt(min(z, w)).
        """
        return np.asarray(np.linalg.norm(self._closed(k), "fro", axis=(1, 2)))

    def slopes(self, k: ComplexVector, derivatives: ComplexVector) -> Vector:
        """Return the derivatives (k, n) of the gains with respect to the controller's n parameters.

        `derivatives` (k, n) are the derivatives of the controller's response K (k,).
        """
        closed, gram = self._gram(k)
        values, vectors = np.linalg.eigh(gram)
        v = vectors[:, :, -1]
        u = np.einsum("kzw,kw->kz", closed, v) / np.sqrt(
            np.maximum(values[:, -1:], np.finfo(float).tiny)
        )
        left = np.einsum("kz,kz->k", u.conj(), self.p12)
        right = np.einsum("kw,kw->k", self.p21, v)
        return np.asarray(
            np.real((left * right / (1.0 - self.p22 * k) ** 2)[:, None] * derivatives)
        )

    def _gram(self, k: ComplexVector) -> tuple[ComplexVector, ComplexVector]:
        closed = self._closed(k)
        return closed, closed.conj().transpose(0, 2, 1) @ closed

    def _closed(self, k: ComplexVector) -> ComplexVector:
        through = k / (1.0 - self.p22 * k)
        return np.asarray(
            self.p11 + through[:, None, None] * self.p12[:, :, None] * self.p21[:, None, :]
        )


def sensitivity_plant(plant: GeneralisedPlant) -> GeneralisedPlant:
    """Return the generalised plant whose closed loop is the sensitivity of `plant`.

    The input w is added to the measurement, and the output z is the measurement.
    """
    one = np.ones((1, 1))
    nothing = np.zeros((len(plant.a), 1))
    return GeneralisedPlant(
        plant.a, nothing, plant.b2, plant.c2, plant.c2, one, 0.0 * one, one, plant.period
    )


def all_stable(k: Lti, plants: Sequence[GeneralisedPlant]) -> bool:
    """Return True if the controller `k` stabilises all plants, which must have the same order."""
    poles = np.linalg.eigvals(np.array([plant.closed(k).a for plant in plants]))
    return bool(np.all(np.abs(poles) < 1.0) if k.period else np.all(poles.real < 0.0))


def true_norms(
    k: Lti, plants: Sequence[GeneralisedPlant], looks: Sequence[Sequence[float]] | None = None
) -> list[tuple[float, float]]:
    """Return the norm of the loop with the controller `k` and its peak frequency, for each plant.

    An unstable loop gives (inf, nan).

    - looks: earlier peak frequencies of each plant, which reduce the computing time
    """
    hints = looks or [()] * len(plants)
    return [
        norm(plant.closed(k), looks=hint or None) for plant, hint in zip(plants, hints, strict=True)
    ]
