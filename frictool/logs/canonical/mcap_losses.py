"""What cannot be read of a canonical log, while the rest of it is salvaged: how many samples of
which stream, and when."""

from __future__ import annotations

from typing import NamedTuple

from frictool.logs.canonical.mcap_sections import FileSection


class CanonicalLoss(NamedTuple):
    """What cannot be read: of one channel, or of all; when, in ns as stored; how many samples; None
    is not known."""

    reason: str
    channel: int | None = None
    first: int | None = None
    last: int | None = None
    samples: int | None = None


class MissingSamples:
    """Appends to `lost` what is missing, as it is found."""

    def __init__(self, lost: list[CanonicalLoss]) -> None:
        self.lost = lost
        self._endless: int | None = (
            None  # the place in `lost` of an interruption that no sample has ended yet
        )

    def unread(self, part: FileSection, last: int | None, size: int) -> None:
        """A part that cannot be read, behind the sample at `last`: the indexes behind it tell what
        was in it, where there are any."""
        if (
            self.lost and "CRC of the" in part.reason
        ):  # of a whole section, in which damage has been found already
            return
        reason = f"{part.reason}, at byte {part.at} of {size}"
        told = [(channel, times) for channel, times in part.indexed() if times.size]
        if told:
            self.lost += [
                CanonicalLoss(reason, channel, int(times.min()), int(times.max()), int(times.size))
                for channel, times in told
            ]
        elif part.empty:
            self.lost.append(CanonicalLoss(reason, samples=0))
        elif self._endless is None:  # else the interruption has been told already
            self._endless = len(self.lost)
            self.lost.append(CanonicalLoss(reason, first=last))

    def until(self, time: int) -> None:
        """The next sample that can be read."""
        if self._endless is not None:
            self.lost[self._endless] = self.lost[self._endless]._replace(last=time)
            self._endless = None

    def check(self, counts: dict[int, int], found: dict[int, int]) -> None:
        """Puts numbers to what was lost, by the statistics' counts: to the one loss that has none,
        else to all of them together."""
        told = {
            number: sum(one.samples or 0 for one in self.lost if one.channel == number)
            for number in counts
        }
        missing = {
            number: count
            for number in counts
            if (count := counts[number] - found[number] - told[number]) > 0
        }
        unknown = [one for one in self.lost if one.samples is None]
        if missing and len(unknown) == 1:
            self.lost.remove(unknown[0])
            self.lost += [
                unknown[0]._replace(channel=number, samples=count)
                for number, count in missing.items()
            ]
        else:
            reason = "the statistics count so many more than are there"
            self.lost += [
                CanonicalLoss(reason, number, samples=count) for number, count in missing.items()
            ]
