"""The worst closed-loop gain over several plants as a function of one controller's response, with
its derivatives.

    T = P11 + P12 K/(1 - P22 K) P21                   sigma = u^H T v              dsigma = Re(u^H
                                                      P12 P21 v dK/(1 - P22 K)²)

u and v are the first singular vectors. With one measurement and one control the controller enters
as a number, so that thousands of responses are evaluated at once. The sensitivity S = 1/(1 - P22 K)
is the same with P11 = P21 = 1 and P12 = P22.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.plant.generalised_plant import GeneralisedPlant
from frictool.plant.lti import Lti
from frictool.verify.hinf_norm import norm

Vector = NDArray[np.float64]
Responses = NDArray[np.complex128]


@dataclass(frozen=True)
class OpenLoopResponses:
    """Responses of one or several plants at k frequencies: p11 (k, z, w), p12 (k, z), p21 (k, w),
    p22 (k,)."""

    p11: Responses
    p12: Responses
    p21: Responses
    p22: Responses

    @staticmethod
    def of(plant: GeneralisedPlant, frequencies: Vector) -> OpenLoopResponses:
        """One plant at the angular frequencies (k,) [rad/s]."""
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
        """All of them, one after the other."""
        return OpenLoopResponses(
            *(
                np.concatenate([getattr(part, name) for part in parts])
                for name in ("p11", "p12", "p21", "p22")
            )
        )

    def sensitivity(self) -> OpenLoopResponses:
        """The loop of which S is the closed form."""
        one = np.ones_like(self.p22)
        return OpenLoopResponses(one[:, None, None], self.p22[:, None], one[:, None], self.p22)

    def gains(self, k: Responses) -> Vector:
        """(k,) largest singular values of the closed loop."""
        _, gram = self._gram(k)
        return np.asarray(np.sqrt(np.maximum(np.linalg.eigvalsh(gram)[:, -1], 0.0)))

    def bounds(self, k: Responses) -> Vector:
        """(k,) upper bounds of the gains, at most sqrt(min(z, w)) times them: the Frobenius norms,
        which cost far less."""
        return np.asarray(np.linalg.norm(self._closed(k), "fro", axis=(1, 2)))

    def slopes(self, k: Responses, derivatives: Responses) -> Vector:
        """(k, n) derivatives of the gains by the parameters of the controller, whose own
        derivatives (k, n) are given."""
        closed, gram = self._gram(k)
        values, vectors = np.linalg.eigh(gram)
        v = vectors[:, :, -1]
        u = np.einsum("kzw,kw->kz", closed, v) / np.sqrt(
            np.maximum(values[:, -1:], np.finfo(float).tiny)
        )
        left, right = np.einsum("kz,kz->k", u.conj(), self.p12), np.einsum("kw,kw->k", self.p21, v)
        return np.asarray(
            np.real((left * right / (1.0 - self.p22 * k) ** 2)[:, None] * derivatives)
        )

    def _gram(self, k: Responses) -> tuple[Responses, Responses]:
        """T and T^H T (k, w, w), whose largest eigenvalue is the square of the gain: a third of the
        time of a decomposition of T."""
        closed = self._closed(k)
        return closed, closed.conj().transpose(0, 2, 1) @ closed

    def _closed(self, k: Responses) -> Responses:
        through = k / (1.0 - self.p22 * k)
        return np.asarray(
            self.p11 + through[:, None, None] * self.p12[:, :, None] * self.p21[:, None, :]
        )


def sensitivity_plant(plant: GeneralisedPlant) -> GeneralisedPlant:
    """The generalised plant of which S is the closed loop: w enters at the measurement, z is the
    measurement."""
    one = np.ones((1, 1))
    nothing = np.zeros((len(plant.a), 1))
    return GeneralisedPlant(
        plant.a, nothing, plant.b2, plant.c2, plant.c2, one, 0.0 * one, one, plant.period
    )


def all_stable(k: Lti, plants: Sequence[GeneralisedPlant]) -> bool:
    """Whether the controller stabilises every plant (all of one order)."""
    poles = np.linalg.eigvals(np.array([plant.closed(k).a for plant in plants]))
    return bool(np.all(np.abs(poles) < 1.0) if k.period else np.all(poles.real < 0.0))


def true_norms(
    k: Lti, plants: Sequence[GeneralisedPlant], looks: Sequence[Sequence[float]] | None = None
) -> list[tuple[float, float]]:
    """The norm of each closed loop and the frequency [rad/s] where it is reached; (inf, nan) where
    the loop is unstable.

    looks: for each plant, where its peaks have been; only the time depends on it.
    """
    hints = looks or [()] * len(plants)
    return [
        norm(plant.closed(k), looks=hint or None) for plant, hint in zip(plants, hints, strict=True)
    ]
