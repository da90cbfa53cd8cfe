"""Record of the samples that are lost in a damaged canonical log."""

from __future__ import annotations

from typing import NamedTuple

from frictool.logs.canonical.mcap_sections import FileSection


class CanonicalLoss(NamedTuple):
    """Samples that could not be read.

    reason: why the samples could not be read.
    channel: channel that lost the samples; None if any channel may have lost samples.
    first, last: times in ns, as stored in the file, between which samples are lost; None if
        unknown.
    samples: number of lost samples; None if unknown.
    """

    reason: str
    channel: int | None = None
    first: int | None = None
    last: int | None = None
    samples: int | None = None


class MissingSamples:
    """Recorder that appends each loss of samples to the list `lost`.

    A loss of unknown length lasts until the next sample that can be read.
    """

    def __init__(self, lost: list[CanonicalLoss]) -> None:
        self.lost = lost
        self._endless: int | None = None  # index in `lost` of a loss that has not ended

    def unread(self, part: FileSection, last: int | None, size: int) -> None:
        """Record a section that cannot be read.

        If the section is a chunk with message indexes after it, the indexes give the number and the
        times of the samples.

        last: time of the last sample before the section, in ns; None if no sample precedes.
        size: size of the file in bytes.
        """
        # the damage that makes the CRC of a section wrong has been recorded already
        if self.lost and "CRC of the" in part.reason:
            return
        reason = f"{part.reason}, at byte {part.at} of {size}"
        indexed = [(channel, times) for channel, times in part.indexed() if times.size]
        if indexed:
            self.lost += [
                CanonicalLoss(reason, channel, int(times.min()), int(times.max()), int(times.size))
                for channel, times in indexed
            ]
        elif part.empty:
            self.lost.append(CanonicalLoss(reason, samples=0))
        elif self._endless is None:  # a loss that has not ended includes this section
            self._endless = len(self.lost)
            self.lost.append(CanonicalLoss(reason, first=last))

    def until(self, time: int) -> None:
        """End the current loss at `time` [ns], the time of the next sample that can be read."""
        if self._endless is not None:
            self.lost[self._endless] = self.lost[self._endless]._replace(last=time)
            self._endless = None

    def check(self, counts: dict[int, int], samples_read: dict[int, int]) -> None:
        """Complete the losses with the numbers of samples that the file's statistics state.

        The statistics may count samples that are neither read nor recorded as lost. If exactly one
        loss has an unknown number of samples, these samples are assigned to that loss. In any other
        case, they are recorded as additional losses.

        counts: number of samples of each channel in the statistics.
        samples_read: number of samples read from each channel.
        """
        lost = {
            number: sum(one.samples or 0 for one in self.lost if one.channel == number)
            for number in counts
        }
        missing = {
            number: count
            for number in counts
            if (count := counts[number] - samples_read[number] - lost[number]) > 0
        }
        unknown = [one for one in self.lost if one.samples is None]
        if missing and len(unknown) == 1:
            self.lost.remove(unknown[0])
            self.lost += [
                unknown[0]._replace(channel=number, samples=count)
                for number, count in missing.items()
            ]
        else:
            reason = "the statistics count these samples, but the file does not contain them"
            self.lost += [
                CanonicalLoss(reason, number, samples=count) for number, count in missing.items()
            ]
