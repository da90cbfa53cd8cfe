"""Loop with a gentle speed controller, for certificates."""

from __future__ import annotations

import numpy as np

from frictool.adapters.state_space import stored_state_space
from frictool.documents.certificate import Box, CertifiedWeights, Filter
from frictool.plant.lti import Lti
from frictool.verify.certificate_loop import CertificateLoop

PERIOD, LAG = 1e-3, 0.003
# a proportional controller with a lead
GENTLE = Lti(*(np.array([[value]]) for value in (0.5, 1.0, -12.0, 30.0)), PERIOD)
WEIGHTS = CertifiedWeights(Filter(31.5, 40.0, 0.635), 0.03, 0.5, 0.5, Filter(0.01))
BOX = Box((1.3e-5, 1.4e-5), (1e-4, 2e-4), (0.018, 0.18), (0.0130, 0.0134))
LOOP = CertificateLoop(stored_state_space(GENTLE), "speed", 1, LAG, PERIOD, WEIGHTS)
