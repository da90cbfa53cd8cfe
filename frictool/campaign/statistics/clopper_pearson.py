"""How well n draws tell a share: Clopper and Pearson's exact bounds (Biometrika 26, 1934), of
independent and of Latin hypercube draws.

A bound is the share p at which a count as far off as the one that was found has just the
probability 1 - confidence; it is exact whatever p and n are. The count of a Latin hypercube is no
binomial one. Its mean has at most the variance of n - 1 independent draws, whatever the function
(Owen, Annals of Statistics 25(4), 1997), so that its bounds are taken as of n - 1 draws with the
same share, and by half a count less: where factors act only together the count may have steps of
two, of which Clopper and Pearson's bounds know nothing. So they are wide where factors act by
themselves, and hold for the worst function that is known, parity in the halves of two factors
(tests/campaign/test_binomial.py).
"""

from __future__ import annotations

from scipy.special import betaincinv

from frictool.campaign.draws.sampling import Method

CONFIDENCE = 0.95
STEP = 0.5  # of a count, see above


def lower(
    count: int, draws: int, confidence: float = CONFIDENCE, method: Method = "random"
) -> float:
    """The share that is reached at least, one-sided, where `count` of `draws` are counted. 0 where
    nothing is."""
    weight = _independent(draws, method)
    if count == 0 or weight == 0.0:
        return 0.0
    found = (count - STEP * (method == "latin" and count < draws)) / draws * weight
    return float(betaincinv(found, weight - found + 1.0, 1.0 - confidence))


def upper(
    count: int, draws: int, confidence: float = CONFIDENCE, method: Method = "random"
) -> float:
    """The share that is reached at most, one-sided."""
    return 1.0 - lower(draws - count, draws, confidence, method)


def interval(
    count: int, draws: int, confidence: float = CONFIDENCE, method: Method = "random"
) -> tuple[float, float]:
    """Both, so that the share is between them with `confidence`: each side misses with half of the
    rest."""
    side = 0.5 * (1.0 + confidence)
    return lower(count, draws, side, method), upper(count, draws, side, method)


def draws_to_show(
    asked: float, share: float, confidence: float = CONFIDENCE, method: Method = "random"
) -> int | None:
    """How many draws would show that `asked` is reached, if the share that passes stayed `share`;
    None where it is not above it."""
    if not share > asked:
        return None
    low, high = 1, 2
    while lower(_counted(share, high), high, confidence, method) < asked:
        low, high = high, 2 * high
        if high > 1 << 40:
            return None
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (
            (low, middle)
            if lower(_counted(share, middle), middle, confidence, method) >= asked
            else (middle, high)
        )
    return high


def _counted(share: float, draws: int) -> int:
    return int(share * draws + 1e-9)


def _independent(draws: int, method: Method) -> float:
    """How many independent draws tell as much at least."""
    return float(draws - 1) if method == "latin" else float(draws)
