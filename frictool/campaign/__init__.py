"""Campaigns: simulate a controller with many plants (drawn or vertices), and find worst cases."""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.campaign.automatic_design import AutomaticDesign as AutomaticDesign
    from frictool.campaign.automatic_design import design_automatically as design_automatically
    from frictool.campaign.campaign_run import CampaignRequest as CampaignRequest
    from frictool.campaign.campaign_run import CampaignResult as CampaignResult
    from frictool.campaign.campaign_run import campaign as campaign
    from frictool.campaign.design_trial import DesignTest as DesignTest
    from frictool.campaign.design_trial import design_test as design_test
    from frictool.campaign.statistics.findings import Findings as Findings
    from frictool.campaign.trials.controller_judge import ControllerJudge as ControllerJudge
    from frictool.campaign.trials.controller_judge import PlayedVerdict as PlayedVerdict
    from frictool.campaign.trials.controller_judge import plants_of_model as plants_of_model
    from frictool.campaign.trials.worst_case import WorstCase as WorstCase
else:
    __getattr__, __dir__, __all__ = lazy_exports(
        __name__,
        {
            "automatic_design": ["AutomaticDesign", "design_automatically"],
            "campaign_run": ["CampaignRequest", "CampaignResult", "campaign"],
            "design_trial": ["DesignTest", "design_test"],
            "statistics.findings": ["Findings"],
            "trials.controller_judge": ["ControllerJudge", "PlayedVerdict", "plants_of_model"],
            "trials.worst_case": ["WorstCase"],
        },
    )
