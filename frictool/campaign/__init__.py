"""Stage: a controller on many plants, drawn, at the corners and where it is worst; what the verdicts of all of them say."""

from typing import TYPE_CHECKING

from frictool.exports import lazily

if TYPE_CHECKING:
    from frictool.campaign.conduct import Campaigned as Campaigned
    from frictool.campaign.conduct import campaign as campaign
    from frictool.campaign.findings import Findings as Findings
    from frictool.campaign.worst_case import WorstCase as WorstCase
else:
    __getattr__, __dir__ = lazily(
        __name__,
        {
            "Campaigned": "frictool.campaign.conduct",
            "Findings": "frictool.campaign.findings",
            "WorstCase": "frictool.campaign.worst_case",
            "campaign": "frictool.campaign.conduct",
        },
    )

__all__ = ["Campaigned", "Findings", "WorstCase", "campaign"]
