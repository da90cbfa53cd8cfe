"""Stage: a controller on many plants, drawn, at the corners and where it is worst; what the verdicts of all of them say."""

from typing import TYPE_CHECKING

from frictool.exports import lazily

if TYPE_CHECKING:
    from frictool.campaign.conduct import Campaigned as Campaigned
    from frictool.campaign.conduct import campaign as campaign
    from frictool.campaign.playing.worst_case import WorstCase as WorstCase
    from frictool.campaign.statistics.findings import Findings as Findings
else:
    __getattr__, __dir__ = lazily(
        __name__,
        {
            "Campaigned": "frictool.campaign.conduct",
            "Findings": "frictool.campaign.statistics.findings",
            "WorstCase": "frictool.campaign.playing.worst_case",
            "campaign": "frictool.campaign.conduct",
        },
    )

__all__ = ["Campaigned", "Findings", "WorstCase", "campaign"]
